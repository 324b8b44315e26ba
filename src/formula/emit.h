/* SPDX-License-Identifier: MIT
 *
 * Points of emitters and directions of their light, by two numbers u, v uniform in (0, 1). Without
 * branches, as turn.h.
 */
#ifndef RMAP_EMIT_H
#define RMAP_EMIT_H

#include "formula/azimuth.h"

/* Uniform on a disc in the plane z = 0. */
static inline struct rmap_vec3 rmap_disc_point(double radius, double u, double v)
{
    double x, y, r = radius * sqrt(u);
    rmap_azimuth(v, &x, &y);
    return rmap_vec3(r * x, r * y, 0.0);
}

static inline struct rmap_vec3 rmap_rectangle_point(const double size[2], double u, double v)
{
    return rmap_vec3((u - 0.5) * size[0], (v - 0.5) * size[1], 0.0);
}

/* A direction about +z by azimuth and 1 - cos(theta), which keeps its digits near the axis. */
static inline struct rmap_vec3 rmap_about_z(double one_minus_cos, double azimuth_turns)
{
    double x, y, sine = sqrt(one_minus_cos * (2.0 - one_minus_cos));
    rmap_azimuth(azimuth_turns, &x, &y);
    return rmap_vec3(sine * x, sine * y, 1.0 - one_minus_cos);
}

/* A direction about +z as one about the unit vector z, x and y across that; unit. */
static inline struct rmap_vec3 rmap_in_frame(struct rmap_vec3 local, struct rmap_vec3 x,
                                             struct rmap_vec3 y, struct rmap_vec3 z)
{
    return rmap_normalize(rmap_axpy(local.x, x, rmap_axpy(local.y, y, rmap_scale(z, local.z))));
}

/* x, y: two unit vectors across the normal. */
static inline struct rmap_vec3 rmap_lambertian(struct rmap_vec3 normal, struct rmap_vec3 x,
                                               struct rmap_vec3 y, double u, double v)
{
    return rmap_in_frame(rmap_about_z(1.0 - sqrt(u), v), x, y, normal);
}

#endif
