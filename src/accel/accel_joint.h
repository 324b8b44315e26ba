/* SPDX-License-Identifier: MIT
 *
 * Joints: rims of analytic surfaces that coincide, as those of two half spheres or of a tube and
 * its lid. Each surface by itself would decide by its own rounded numbers whether a line passes
 * inside its rim, and light would leak between two that differ. Near a shared rim the line's side
 * of it is decided once, from the ray and one of the rims, for all surfaces that end there.
 *
 * Across the rim, where w is its tangent, surfaces are half lines from a point P in directions a,
 * b, and a line q + t e passes P on the side of the sign of [P - q, e, w]. It crosses the surface a
 * where [P - q, e, w] + u [a, e, w] = 0 with u > 0. If a and b lie on two sides of the line it so
 * crosses exactly one of them, if on one side both or none. A ray that starts on the surface a,
 * however near to P, has the sign of -[a, e, w].
 */
#ifndef RMAP_ACCEL_JOINT_H
#define RMAP_ACCEL_JOINT_H

#include "accel/accel_internal.h"

/* rmap_joints_build: after the objects have their tolerances. rmap_joint_at_start:
 * do the start's shape and this one share a rim at which the ray starts? Then *meets_ret: does the
 * ray cross this one there? */
enum rmap_status rmap_joints_build(struct rmap_accel *accel, struct rmap_error *err) RMAP_MUST_USE;
void rmap_joints_release(struct rmap_accel *accel);
bool rmap_joint_at_start(const struct rmap_query *query, int32_t object, bool *meets_ret);

#endif
