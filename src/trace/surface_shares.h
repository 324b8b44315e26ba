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
    double missing; /* of `absorb`: what facets sent to other facets */
};

/* A side of an object that light meets. */
struct rmap_surface_side {
    const struct rmap_object *object;
    bool front; /* light comes from there */
};

/* Of a medium on a channel. NaN where it is not that of a medium alone (gradient media) or not
 * stated. */
double rmap_medium_index(const struct rmap_scene *scene, int32_t medium, int channel);

/* On a channel, from index n1 into n2 at cos_i in [0, 1]; NaN where an index is that it depends on.
 */
struct rmap_surface_shares rmap_surface_shares(const struct rmap_scene *scene,
                                               struct rmap_surface_side side, int channel,
                                               double n1, double n2, double cos_i);

/* reflect_specular of these, sooner. */
double rmap_surface_reflectance(const struct rmap_scene *scene, struct rmap_surface_side side,
                                int channel, double n1, double n2, double cos_i);

/* Of a surface with a scatter model, 1/sr: between the media of the object, in the plane of
 * incidence, to an angle from the normal, positive on the side of the specular direction. passes:
 * of transmitted light. */
double rmap_side_bsdf(const struct rmap_scene *scene, struct rmap_surface_side side, int channel,
                      double incidence_deg, double scatter_deg, bool passes);

/* Between the media of the object, at an angle of incidence. */
struct rmap_surface_shares rmap_side_shares(const struct rmap_scene *scene,
                                            struct rmap_surface_side side, int channel,
                                            double angle_deg);

#endif
