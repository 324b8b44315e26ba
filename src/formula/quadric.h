/* SPDX-License-Identifier: MIT
 *
 * Surfaces of revolution of second degree about z:
 *
 *     F = alpha (x^2 + y^2) + gamma z^2 + 2 delta z + epsilon = 0
 *
 * Along a ray F = A t^2 + 2 B t + C. The ray is first moved to its point nearest to the shape,
 * where the coefficients are as small as they can be; the roots are then as good as the
 * coordinates.
 */
#ifndef RMAP_QUADRIC_H
#define RMAP_QUADRIC_H

#include "base/vec.h"

struct rmap_quadric {
    double alpha, gamma, delta, epsilon;
    double middle; /* z about which the surface lies */
};

/* Half the gradient of F. */
static inline struct rmap_vec3 rmap_quadric_half_gradient(const struct rmap_quadric *f,
                                                          struct rmap_vec3 p)
{
    return rmap_vec3(f->alpha * p.x, f->alpha * p.y, f->gamma * p.z + f->delta);
}

static inline double rmap_quadric_value(const struct rmap_quadric *f, struct rmap_vec3 p)
{
    return f->alpha * (p.x * p.x + p.y * p.y) + (f->gamma * p.z + 2 * f->delta) * p.z + f->epsilon;
}

static inline double rmap_quadric_square(const struct rmap_quadric *f, struct rmap_vec3 d)
{
    return f->alpha * (d.x * d.x + d.y * d.y) + f->gamma * d.z * d.z;
}

/* How far it is to the point of the ray nearest to the shape. */
static inline double rmap_quadric_shift(const struct rmap_quadric *f, struct rmap_vec3 origin,
                                        struct rmap_vec3 d)
{
    struct rmap_vec3 from = rmap_vec3(origin.x, origin.y, origin.z - f->middle);
    return -rmap_dot(from, d) / rmap_dot(d, d);
}

/* From a point of the surface, which is a root: the other one. */
static inline double rmap_quadric_other(const struct rmap_quadric *f, struct rmap_vec3 origin,
                                        struct rmap_vec3 d)
{
    return -2 * rmap_dot(rmap_quadric_half_gradient(f, origin), d) / rmap_quadric_square(f, d);
}

/* What of it is a surface, for compact maps: limits are infinite where a shape has none. Numbers
 * alone, so that several are read side by side. */
struct rmap_bounded_quadric {
    struct rmap_quadric form;
    double inner2, outer2; /* of the distance from the axis, squared */
    double sheet;          /* 1 - sheet z >= 0 on the sheet that counts, up to rounding */
    double low, high;      /* of z */
    double sign;           /* of the gradient in the normal */
    double rigid;          /* 1: its object's map keeps lengths; else 0 */
};

/* Both roots along a ray, the lesser first, from its point nearest to the shape, `shift` from its
 * origin. */
struct rmap_quadric_roots {
    double shift, t0, t1;
    struct rmap_vec3 near; /* that point */
    double missed;         /* 1: there is none; else 0 */
};

static inline struct rmap_quadric_roots
rmap_quadric_meet(const struct rmap_quadric *f, struct rmap_vec3 origin, struct rmap_vec3 d)
{
    double shift = rmap_quadric_shift(f, origin, d);
    struct rmap_vec3 p = rmap_axpy(shift, d, origin);
    double a = rmap_quadric_square(f, d), b = rmap_dot(rmap_quadric_half_gradient(f, p), d);
    double c = rmap_quadric_value(f, p), discriminant = b * b - a * c;
    double root = sqrt(discriminant), sum = b < 0 ? root - b : -(b + root);
    double near = sum != 0.0 ? c / sum : 0.0, far = sum / a;
    far = far - far == 0.0 ? far : near; /* beyond all numbers */
    double some = sum != 0.0 ? 1.0 : a != 0.0 ? 1.0 : 0.0;
    return (struct rmap_quadric_roots){shift, near < far ? near : far, near < far ? far : near, p,
                                       discriminant >= 0.0 ? 1.0 - some : 1.0};
}

/* The first root ahead of `behind` whose point belongs to the surface; failing that, the last. The
 * tracer (geometry/shape_solve.h) chooses by its own limits and shared rims, and says whether that
 * is the same root. */
static inline double rmap_quadric_choose(const struct rmap_bounded_quadric *q, double behind,
                                         const struct rmap_quadric_roots *roots, struct rmap_vec3 d,
                                         struct rmap_vec3 *point)
{
    struct rmap_vec3 first = rmap_axpy(roots->t0, d, roots->near);
    double s = first.x * first.x + first.y * first.y;
    double outside = roots->shift + roots->t0 > behind ? 0.0 : 1.0;
    outside = s <= q->outer2 ? outside : 1.0;
    outside = s >= q->inner2 ? outside : 1.0;
    outside = 1 - q->sheet * first.z >= -0x1p-50 ? outside : 1.0;
    outside = first.z >= q->low ? outside : 1.0;
    outside = first.z <= q->high ? outside : 1.0;
    double t = outside > 0.0 ? roots->t1 : roots->t0;
    *point = rmap_axpy(t, d, roots->near);
    return roots->shift + t;
}

/* Unit normal at a point of it, in its frame; a cone's apex has the axis. */
static inline struct rmap_vec3 rmap_quadric_unit_normal(const struct rmap_bounded_quadric *q,
                                                        struct rmap_vec3 point)
{
    struct rmap_vec3 g = rmap_quadric_half_gradient(&q->form, point);
    g = rmap_vec3(q->sign * g.x, q->sign * g.y, q->sign * g.z);
    double length = rmap_length(g), some = length > 0 ? length : 1.0;
    struct rmap_vec3 n = rmap_scale(g, 1 / some);
    return rmap_vec3(n.x, n.y, length > 0 ? n.z : 1.0);
}

#endif
