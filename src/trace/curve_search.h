/* SPDX-License-Identifier: MIT
 *
 * The first surface that a curve meets, step by step.
 *
 * Chords of the curve are tested against the scene. Where one meets a surface, the place where the
 * curve crosses that surface's tangent plane says where a chord short enough to be the curve
 * itself, within a tenth of the tolerance, must decide. Where none does, the control polygon on the
 * curve's outer side is tested too: a surface that crosses neither, nor ends between them, does not
 * cross the curve; else the piece is halved. So only bodies and gaps smaller than the sag can be
 * passed over, and that is bounded by the medium's `sag`.
 */
#ifndef RMAP_CURVE_SEARCH_H
#define RMAP_CURVE_SEARCH_H

#include "geometry/accel.h"
#include "gradient/curve.h"

struct rmap_curve_search {
    const struct rmap_accel *accel;           /* borrowed */
    const struct rmap_curve_options *options; /* borrowed */
    struct rmap_ray ray;     /* of the chord in hand; contact: as long as it starts the leg */
    struct rmap_vec3 normal; /* of the surface that the leg starts on */
};

/* A leg that starts as `ray` does; normal: of the surface it starts on, if its contact has one. */
void rmap_curve_search_begin(struct rmap_curve_search *search, const struct rmap_accel *accel,
                             const struct rmap_curve_options *options, const struct rmap_ray *ray,
                             struct rmap_vec3 normal);

/* The first surface on the step up to theta `end`; steps in order, the first from the leg's start.
 * hit: position on the surface; t: 0 for a surface that touches the leg's start, else > 0. */
bool rmap_curve_search_step(struct rmap_curve_search *search, const struct rmap_curve_step *step,
                            double end, double *theta, struct rmap_hit *hit);

#endif
