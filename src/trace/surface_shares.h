/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a side of an object, by share: what interact.c draws from.
 */
#ifndef RMAP_SURFACE_SHARES_H
#define RMAP_SURFACE_SHARES_H

#include "scene/scene.h"

/* Shares of unpolarised light; they sum to 1. */
struct rmap_surface_shares {
    double reflect_specular, reflect_diffuse, transmit_specular, transmit_diffuse, absorb;
};

/* On a channel, of light that comes from the object's front or back at cos_i in [0, 1]. NaN where
 * an index is not that of a place alone (gradient media) or not stated. */
struct rmap_surface_shares rmap_surface_shares(const struct rmap_scene *scene,
                                               const struct rmap_object *object, bool front,
                                               int channel, double cos_i);

#endif
