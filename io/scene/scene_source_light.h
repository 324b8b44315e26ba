/* SPDX-License-Identifier: MIT
 *
 * Flux and spectrum of a source. They wait until it is known whether the scene counts in W or lm.
 */
#ifndef RMAP_SCENE_SOURCE_LIGHT_H
#define RMAP_SCENE_SOURCE_LIGHT_H

#include "io/scene/scene_reader.h"

struct rmap_source_light {
    const struct rmap_yaml_node *node; /* the source */
    struct rmap_spectrum spectrum;
    bool spectrum_given, lumens;
    bool either;    /* its numbers are of whatever unit the other sources have */
    double flux;    /* W or lm */
    int32_t source; /* index */
};

/* "flux" of the source's node; 1 W where it says nothing. */
void rmap_reader_read_flux(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source_light *light);

/* Flux and colour of the scene's source, once the scene's channels and unit are known. */
void rmap_reader_settle_light(struct rmap_reader *reader, const struct rmap_source_light *light);

#endif
