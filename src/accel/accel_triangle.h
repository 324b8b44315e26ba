/* SPDX-License-Identifier: MIT
 *
 * Does the ray cross this triangle? Decided in double so that a mesh has no holes: the corners
 * are sheared into a plane in which the ray is the origin (Woop, Benthin and Wald 2013, JCGT
 * 2(1), "Watertight ray/triangle intersection"); each corner is rounded once, whatever triangle
 * it is looked at for, and on which side of an edge the origin lies is then exact. Triangles
 * that share an edge or a corner therefore agree, and the next surface does not depend on the
 * instruction set that Embree uses.
 */
#ifndef RMAP_ACCEL_TRIANGLE_H
#define RMAP_ACCEL_TRIANGLE_H

#include "accel/accel_internal.h"

/* True when the surface came nearer than all before, so that the limit has shrunk. */
bool rmap_consider_triangle(struct rmap_query *query, int32_t object, int32_t primitive);
bool rmap_consider_neighbours(struct rmap_query *query, int32_t object, int32_t primitive);
bool rmap_consider_shape(struct rmap_query *query, int32_t object);
const struct rmap_candidate *rmap_query_best(const struct rmap_query *query);
void rmap_query_enter(struct rmap_query *query, int32_t object);

/* Brings query->local into the object's frame. */
static inline void rmap_query_local(struct rmap_query *query, int32_t object)
{
    if (query->local.object != object)
        rmap_query_enter(query, object);
}

#endif
