/* SPDX-License-Identifier: MIT
 *
 * Shared by the files that solve the shapes, and by the accelerator; no other folder needs it.
 */
#ifndef RMAP_SHAPE_INTERNAL_H
#define RMAP_SHAPE_INTERNAL_H

#include "geometry/sag.h"
#include "geometry/shape.h"

struct rmap_joints; /* accel_joint.c */

/* A query against one shape: origin + t direction, t_min < t < t_max. */
struct rmap_shape_query {
    struct rmap_vec3 origin, direction;
    bool on_surface;
    double t_min, t_max;
    double behind;              /* a root up to here lies behind the start, whoever asks */
    struct rmap_joints *joints; /* rims that are shared with other shapes; NULL: none */
};

/* Does a root at t belong to the surface? Where a shared rim is near, it decides, and a point
 * beyond it is put onto it; elsewhere `plain`, what the shape's own numbers say, is the answer. */
bool rmap_joints_decide(struct rmap_joints *joints, double t, struct rmap_vec3 *point, bool plain);

static inline bool rmap_root_belongs(const struct rmap_shape_query *query, double t,
                                     struct rmap_vec3 *point, bool plain)
{
    return query->joints ? rmap_joints_decide(query->joints, t, point, plain) : plain;
}

/* Sag of a CONIC as a function of s = r^2, and its derivative dz/ds. */
double rmap_conic_sag(const struct rmap_shape *shape, double s);
double rmap_conic_slope(const struct rmap_shape *shape, double s);

/* CONIC with aspheric terms, SAG. */
bool rmap_asphere_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                            struct rmap_shape_hit *hit);

/* WALL. */
struct rmap_vec3 rmap_wall_normal(const struct rmap_shape *shape, struct rmap_vec3 point);
bool rmap_wall_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                         struct rmap_shape_hit *hit);

/* Range of the sag of a CONIC over inner <= r <= aperture, never too narrow. */
void rmap_asphere_sag_range(const struct rmap_shape *shape, double *lower, double *upper);

/* Unit normal at a point of the surface. */
struct rmap_vec3 rmap_shape_normal(const struct rmap_shape *shape, struct rmap_vec3 point);

#endif
