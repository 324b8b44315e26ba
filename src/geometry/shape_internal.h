/* SPDX-License-Identifier: MIT
 *
 * Shared by the files that solve the shapes, and by the accelerator; no other folder needs it.
 */
#ifndef RMAP_SHAPE_INTERNAL_H
#define RMAP_SHAPE_INTERNAL_H

#include "geometry/shape.h"

/* A query against one shape: origin + t direction, t_min < t < t_max. */
struct rmap_shape_query {
    struct rmap_vec3 origin, direction;
    bool on_surface;
    double t_min, t_max;
    double behind; /* a root up to here lies behind the start, whoever asks */
};

/* Sag of a CONIC as a function of s = r^2, and its derivative dz/ds. */
double rmap_conic_sag(const struct rmap_shape *shape, double s);
double rmap_conic_slope(const struct rmap_shape *shape, double s);

/* CONIC with aspheric terms. */
bool rmap_asphere_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                            struct rmap_shape_hit *hit);

/* Range of the sag over inner <= r <= aperture, never too narrow. */
void rmap_asphere_sag_range(const struct rmap_shape *shape, double *lower, double *upper);

/* Unit normal at a point of the surface. */
struct rmap_vec3 rmap_shape_normal(const struct rmap_shape *shape, struct rmap_vec3 point);

#endif
