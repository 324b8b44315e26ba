/* SPDX-License-Identifier: MIT
 *
 * Where a surface over the plane z = 0 ends: an ellipse or a rectangle, with a round hole about its
 * middle.
 */
#ifndef RMAP_APERTURE_H
#define RMAP_APERTURE_H

#include "base/vec.h"

struct rmap_aperture {
    bool rectangle;
    double half[2], at[2]; /* along x and y; a circle is an ellipse of two equal ones */
    double inner;          /* radius of the hole */
};

bool rmap_aperture_is_circle(const struct rmap_aperture *a); /* about the axis */
bool rmap_aperture_same(const struct rmap_aperture *a, const struct rmap_aperture *b);

/* Hole and all. */
bool rmap_aperture_has(const struct rmap_aperture *a, double x, double y);

/* The part of the line p + t d over the aperture, hole and all: cuts the range t. False: none. */
bool rmap_aperture_clip(const struct rmap_aperture *a, struct rmap_vec3 p, struct rmap_vec3 d,
                        double t[2]);

/* Point of the rim, or of the hole, u in [0, 1) around it from +x to +y; every eighth is a corner
 * or a middle of a rectangle. v: 0 at the rim, 1 at the hole or the middle; z = 0. */
struct rmap_vec3 rmap_aperture_chart(const struct rmap_aperture *a, double u, double v);
void rmap_aperture_find(const struct rmap_aperture *a, double x, double y, double *u, double *v);

/* Unit normal of its rim at a point there; and of a side of a rectangle, 0 to 3 for +x, +y, -x, -y.
 */
struct rmap_vec3 rmap_aperture_outward(const struct rmap_aperture *a, double x, double y);
static inline struct rmap_vec3 rmap_side_outward(int side)
{
    const double sign = side < 2 ? 1 : -1;
    return side % 2 ? rmap_vec3(0, sign, 0) : rmap_vec3(sign, 0, 0);
}

/* From the axis, of what lies within the rim: nearest (of the rim; 0 where that is not about the
 * axis) and farthest. */
double rmap_aperture_near(const struct rmap_aperture *a);
double rmap_aperture_far(const struct rmap_aperture *a);

const char *rmap_aperture_check(const struct rmap_aperture *a);

#endif
