/* SPDX-License-Identifier: MIT
 *
 * Where an analytic surface ends: circles about its axis, or the edges of a rectangle. In the
 * shape's own frame.
 */
#ifndef RMAP_SHAPE_RIM_H
#define RMAP_SHAPE_RIM_H

#include "geometry/shape.h"

#define RMAP_RIM_MAX 4 /* of one shape */

struct rmap_rim {
    bool straight;
    double size;             /* radius, or half the length */
    double z;                /* circle: its height */
    double radial, axial;    /* circle: unit tangent of the surface at it, inward */
    struct rmap_vec3 at;     /* edge: its middle */
    struct rmap_vec3 along;  /* edge: unit */
    struct rmap_vec3 inward; /* edge: unit tangent of the surface */
};

/* A point of a rim and the two tangents there: of the rim, and of the surface away from it. Unit
 * and orthogonal. */
struct rmap_rim_point {
    struct rmap_vec3 at, along, inward;
};

/* How many rims the shape has. */
int rmap_shape_rims(const struct rmap_shape *shape, struct rmap_rim rim[RMAP_RIM_MAX]);

/* Is p, a point of the shape continued beyond its rims, near this one: within `zone` of its size?
 */
bool rmap_rim_is_near(const struct rmap_rim *rim, struct rmap_vec3 p, double zone);

/* The point of the rim (of an edge: of its line) nearest to p. */
struct rmap_rim_point rmap_rim_point(const struct rmap_rim *rim, struct rmap_vec3 p);

#endif
