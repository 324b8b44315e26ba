/* SPDX-License-Identifier: MIT
 *
 * Light from far away: skies, the sun, pictures of all that is around.
 */
#ifndef RMAP_SCENE_SKIES_H
#define RMAP_SCENE_SKIES_H

#include "io/scene/scene_reader.h"
#include "io/scene/scene_source_light.h"

/* Where the sun stands, in degrees: azimuth from north over east, altitude. */
struct rmap_sun_seen {
    double azimuth, altitude, nearness;
    bool known;
};

/* A source of type `sky` or `sun`: its directions. How bright it is, is settled later. */
void rmap_reader_read_sky(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_source *source, struct rmap_source_light *light);

/* Once objects and detectors stand: what is to be lit, the portals, flux. */
void rmap_reader_aim_skies(struct rmap_reader *reader);

#endif
