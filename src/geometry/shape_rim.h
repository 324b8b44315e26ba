/* SPDX-License-Identifier: MIT
 *
 * Where an analytic surface ends: circles about its axis, the edges of a rectangle, or curves that
 * follow a sag along an outline. In the shape's own frame.
 */
#ifndef RMAP_SHAPE_RIM_H
#define RMAP_SHAPE_RIM_H

#include "geometry/shape.h"

#define RMAP_RIM_MAX 5 /* of one shape */

struct rmap_rim {
    bool straight;
    double size;                    /* radius, or half the length */
    double z;                       /* circle: its height */
    double radial, axial;           /* circle: unit tangent of the surface at it, inward */
    struct rmap_vec3 at;            /* edge: its middle */
    struct rmap_vec3 along;         /* edge: unit */
    struct rmap_vec3 inward;        /* edge: unit tangent of the surface */
    const struct rmap_shape *curve; /* curve: its shape, whose sag it follows; else NULL */
    int end, side; /* curve: 0 bottom, 1 top of a WALL; +x, +y, -x, -y of a rectangle; -1 the whole
                      of an ellipse, -2 the hole */
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

/* Point i of n that are even along the rim: of a circle or curve around it, of an edge and a side
 * from end to end. */
struct rmap_vec3 rmap_rim_sample(const struct rmap_rim *rim, int i, int n);

/* Its middle. */
struct rmap_vec3 rmap_rim_middle(const struct rmap_rim *rim);

/* The point of the rim (of an edge: of its line) nearest to p. */
struct rmap_rim_point rmap_rim_point(const struct rmap_rim *rim, struct rmap_vec3 p);

#endif
