/* SPDX-License-Identifier: MIT
 *
 * Skies and the sun as grids of radiance over direction.
 */
#ifndef RMAP_SCENE_SKY_MODELS_H
#define RMAP_SCENE_SKY_MODELS_H

#include "io/scene/scene_skies.h"
#include "optics/sky_luminance.h"
#include "optics/sun.h"

/* In the frame of a sky: x south, y east, z up. Degrees; altitude 0 to 90. */
struct rmap_vec3 rmap_sky_direction(double azimuth, double altitude);

/* By its pattern, 1 at the zenith, and dark below the horizon. */
enum rmap_status rmap_sky_of_pattern(const struct rmap_sky_pattern *pattern,
                                     const struct rmap_sun_seen *sun, struct rmap_sky *sky,
                                     struct rmap_error *err) RMAP_MUST_USE;
/* 1 in all directions. */
enum rmap_status rmap_sky_of_all(struct rmap_sky *sky, struct rmap_error *err) RMAP_MUST_USE;
/* About the frame's z. */
enum rmap_status rmap_sky_of_sun(enum rmap_sunshape shape, double size, struct rmap_sky *sky,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
