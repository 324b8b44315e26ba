/* SPDX-License-Identifier: MIT
 *
 * The prefilter: scenes of few analytic surfaces are searched without a tree. Every shape lies in a
 * shell about its axis, low <= z <= high, inner <= r <= outer; eight shells at a time are held
 * against the float ray, and what is left is solved in double, nearest first. All shells are
 * wider than the float error, so nothing that Embree would propose is lost.
 */
#ifndef RMAP_ACCEL_PREFILTER_H
#define RMAP_ACCEL_PREFILTER_H

#include "accel/accel_internal.h"

/* rmap_prefilter_build: no more than RMAP_PREFILTER_MAX shapes. rmap_prefilter_search: all
 * shapes that may be the next surface, for a float ray that begins `shift` from the start. */
void rmap_prefilter_build(struct rmap_accel *accel);
void rmap_prefilter_search(struct rmap_query *query, const float origin[3],
                           const float direction[3], double shift);

/* The same for up to 8 spheres, which the prefilter then leaves out. */
void rmap_spheres_build(struct rmap_accel *accel);
void rmap_spheres_search(struct rmap_query *query, const float origin[3], const float direction[3],
                         double shift);

/* rmap_clearance_holds: nothing as far as the limit can be a shape, of a float ray
 * that begins `shift` from the start, there or on the shape at which one of the box's sides ends.
 */
void rmap_clearance_build(struct rmap_accel *accel);
bool rmap_clearance_holds(const struct rmap_query *query, const float origin[3],
                          const float direction[3], double shift);

#endif
