/* SPDX-License-Identifier: MIT
 *
 * Flux and spectrum of a source. They wait until it is known what the scene counts in.
 */
#ifndef RMAP_SCENE_SOURCE_LIGHT_H
#define RMAP_SCENE_SOURCE_LIGHT_H

#include "io/scene/scene_reader.h"

struct rmap_source_light {
    const struct rmap_yaml_node *node; /* the source */
    struct rmap_spectrum spectrum;
    bool spectrum_given;
    enum rmap_flux_unit unit;
    bool bare;      /* no unit is written */
    bool either;    /* its numbers are of whatever unit the other sources have */
    double flux;    /* in that unit */
    int32_t source; /* index */
};

/* "flux" of the source's node; 1 W where it says nothing. */
void rmap_reader_read_flux(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source_light *light);

/* What the scene counts in, of the lights of all sources: the unit that all have; W of powers in
 * several (W, lm, photons/s), J of amounts (photons, J). Powers and amounts are no scene. */
void rmap_reader_settle_unit(struct rmap_reader *reader, const struct rmap_source_light *light,
                             size_t n);

/* Flux and colour of the scene's source, once the scene's channels and unit are known. */
void rmap_reader_settle_light(struct rmap_reader *reader, const struct rmap_source_light *light);

#endif
