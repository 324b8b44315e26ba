/* SPDX-License-Identifier: MIT
 *
 * Where the ray starts. Four questions are decided here, all by topology rather than by a
 * distance to be skipped:
 *
 * - A start at an edge of its triangle, to double rounding: does the neighbour lie ahead? Topology
 *   is then decided for a point a hair inside the triangle, and on the side that the ray takes.
 * - A surface that coincides with the start and is parallel to it: touching faces. The contact
 *   list says whether it is still to be met.
 * - A shape that shares the rim at which the ray starts: see accel_joint.c.
 * - One that crosses the start: it counts when the start's triangle lies on the side from which
 *   the ray would meet it.
 */
#ifndef RMAP_ACCEL_START_H
#define RMAP_ACCEL_START_H

#include "accel/accel_internal.h"

void rmap_start_find(struct rmap_query *query);
bool rmap_start_meets(struct rmap_query *query, struct rmap_touch *touch);

#endif
