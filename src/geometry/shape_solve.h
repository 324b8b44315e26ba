/* SPDX-License-Identifier: MIT
 *
 * Where a ray meets an analytic surface. Those of second degree (formula/quadric.h):
 *
 *     CONIC   alpha = c, gamma = c (1 + k), delta = -1, epsilon = 0
 *     TUBE    alpha = 1, gamma = -m^2, delta = -m radius, epsilon = -radius^2
 *     SPHERE  alpha = gamma = 1, delta = 0, epsilon = -radius^2
 */
#ifndef RMAP_SHAPE_SOLVE_H
#define RMAP_SHAPE_SOLVE_H

#include <float.h>

#include "formula/quadric.h"
#include "geometry/shape_internal.h"

static inline struct rmap_quadric rmap_quadric_of(const struct rmap_shape *shape)
{
    double m;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC: /* solved as planes */
    case RMAP_SHAPE_RECTANGLE:
        return (struct rmap_quadric){shape->curvature, shape->curvature * (1 + shape->conic), -1, 0,
                                     0};
    case RMAP_SHAPE_TUBE:
        m = (shape->radius2 - shape->radius) / shape->length;
        return (struct rmap_quadric){1, -m * m, -m * shape->radius, -shape->radius * shape->radius,
                                     0.5 * shape->length};
    case RMAP_SHAPE_SPHERE:
    case RMAP_SHAPE_SAG: /* solved otherwise */
    case RMAP_SHAPE_WALL:
        break;
    }
    return (struct rmap_quadric){1, 1, 0, -shape->radius * shape->radius, 0};
}

/* Is a point of the whole quadric a point of the surface? */
static inline bool rmap_quadric_belongs(const struct rmap_shape *shape, struct rmap_vec3 p)
{
    if (shape->type == RMAP_SHAPE_SPHERE)
        return true;
    if (shape->type == RMAP_SHAPE_TUBE)
        return p.z >= 0 && p.z <= shape->length;
    double s = p.x * p.x + p.y * p.y;
    if (s > shape->aperture * shape->aperture || s < shape->inner * shape->inner)
        return false;
    /* 1 - (1 + k) c z is the root in the sag formula: negative on the sheet, or the half of an
     * ellipsoid, that the formula does not describe. */
    return 1 - (1 + shape->conic) * shape->curvature * p.z >= -4 * DBL_EPSILON;
}

static inline struct rmap_vec3 rmap_quadric_normal_at(const struct rmap_shape *shape,
                                                      const struct rmap_quadric *f,
                                                      struct rmap_vec3 p)
{
    struct rmap_vec3 g = rmap_quadric_half_gradient(f, p);
    if (shape->type == RMAP_SHAPE_CONIC)
        g = rmap_scale(g, -1);
    double length = rmap_length(g);
    return length > 0 ? rmap_scale(g, 1 / length) : rmap_vec3(0, 0, 1); /* a cone's apex */
}

/* The roots in increasing order; how many. Neither is found by subtracting what is nearly equal
 * (Press et al., Numerical Recipes, section 5.6). */
static inline int rmap_quadric_roots(double a, double b, double c, double t[2])
{
    double discriminant = b * b - a * c;
    if (!(discriminant >= 0))
        return 0;
    double q = -(b + copysign(sqrt(discriminant), b));
    if (q == 0) { /* b = 0 and a c = 0 */
        t[0] = 0;
        return a != 0 ? 1 : 0;
    }
    if (a == 0) {
        t[0] = c / q;
        return 1;
    }
    double far = q / a;
    double near = c / q;
    if (!isfinite(far)) {
        t[0] = near;
        return 1;
    }
    t[0] = near < far ? near : far;
    t[1] = near < far ? far : near;
    return 2;
}

static inline bool rmap_quadric_take(const struct rmap_shape *shape, const struct rmap_quadric *f,
                                     const struct rmap_shape_query *query, double t,
                                     struct rmap_vec3 point, struct rmap_shape_hit *hit)
{
    if (!(t > query->t_min && t < query->t_max) ||
        !rmap_root_belongs(query, t, &point, rmap_quadric_belongs(shape, point)))
        return false;
    hit->t = t;
    hit->point = point;
    hit->normal = rmap_quadric_normal_at(shape, f, point);
    return true;
}

/* The origin is a root: the other one is -2 B / A. */
static inline bool rmap_quadric_other_side(const struct rmap_shape *shape,
                                           const struct rmap_quadric *f,
                                           const struct rmap_shape_query *query,
                                           struct rmap_shape_hit *hit)
{
    struct rmap_vec3 d = query->direction;
    double t = rmap_quadric_other(f, query->origin, d);
    if (!isfinite(t))
        return false;
    hit->predicted = true;
    return rmap_quadric_take(shape, f, query, t, rmap_axpy(t, d, query->origin), hit);
}

/* Is root i of n, which was taken, the one that src/compact takes? The first one ahead that belongs
 * to the surface, failing that the last. */
static inline bool rmap_quadric_predicted(const struct rmap_shape *shape, double behind,
                                          const double root[2], int i, double shift,
                                          struct rmap_vec3 first)
{
    if (i == 0)
        return shift + root[0] > 0;
    return shift + root[0] <= behind || !rmap_quadric_belongs(shape, first);
}

static inline bool rmap_quadric_intersect(const struct rmap_shape *shape,
                                          const struct rmap_shape_query *query,
                                          struct rmap_shape_hit *hit)
{
    struct rmap_quadric f = rmap_quadric_of(shape);
    if (query->on_surface)
        return rmap_quadric_other_side(shape, &f, query, hit);
    struct rmap_vec3 d = query->direction;
    double shift = rmap_quadric_shift(&f, query->origin, d);
    struct rmap_vec3 p = rmap_axpy(shift, d, query->origin);
    double a = rmap_quadric_square(&f, d);
    double b = rmap_dot(rmap_quadric_half_gradient(&f, p), d);
    double t[2];
    int n = rmap_quadric_roots(a, b, rmap_quadric_value(&f, p), t);
    for (int i = 0; i < n; i++) {
        if (!rmap_quadric_take(shape, &f, query, shift + t[i], rmap_axpy(t[i], d, p), hit))
            continue;
        /* b = -0 leads to roots that are rounded in another way there */
        hit->predicted =
            !(b == 0 && signbit(b)) &&
            rmap_quadric_predicted(shape, query->behind, t, i, shift, rmap_axpy(t[0], d, p));
        return true;
    }
    return false;
}

static inline bool rmap_inside_flat(const struct rmap_shape *shape, double x, double y)
{
    if (shape->type == RMAP_SHAPE_RECTANGLE)
        return fabs(x) <= 0.5 * shape->size[0] && fabs(y) <= 0.5 * shape->size[1];
    double s = x * x + y * y;
    return s <= shape->aperture * shape->aperture && s >= shape->inner * shape->inner;
}

static inline bool rmap_flat_intersect(const struct rmap_shape *shape,
                                       const struct rmap_shape_query *query,
                                       struct rmap_shape_hit *hit)
{
    struct rmap_vec3 p = query->origin, d = query->direction;
    if (query->on_surface || d.z == 0)
        return false;
    double t = -p.z / d.z;
    struct rmap_vec3 at = rmap_vec3(p.x + t * d.x, p.y + t * d.y, 0);
    if (!(t > query->t_min && t < query->t_max) ||
        !rmap_root_belongs(query, t, &at, rmap_inside_flat(shape, at.x, at.y)))
        return false;
    *hit = (struct rmap_shape_hit){t, at, rmap_vec3(0, 0, 1), true};
    return true;
}

/* rmap_shape_intersect, where a call costs too much. */
static inline bool rmap_shape_solve(const struct rmap_shape *shape,
                                    const struct rmap_shape_query *query,
                                    struct rmap_shape_hit *hit)
{
    if (shape->type == RMAP_SHAPE_DISC || shape->type == RMAP_SHAPE_RECTANGLE)
        return rmap_flat_intersect(shape, query, hit);
    if ((shape->type == RMAP_SHAPE_CONIC && shape->n_asphere > 0) || shape->type == RMAP_SHAPE_SAG)
        return rmap_asphere_intersect(shape, query, hit);
    if (shape->type == RMAP_SHAPE_WALL)
        return rmap_wall_intersect(shape, query, hit);
    return rmap_quadric_intersect(shape, query, hit);
}

#endif
