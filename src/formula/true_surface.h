/* SPDX-License-Identifier: MIT
 *
 * The surface that a face of a CAD model lies on, whole and without an edge, in the frame of its
 * mesh: where a line meets it, how far a point is from it, its normal. The tracer and the decoder
 * of compact maps find the same bits.
 */
#ifndef RMAP_TRUE_SURFACE_H
#define RMAP_TRUE_SURFACE_H

#include "formula/quadric.h"
#include "formula/torus.h"

/* As in a PLY file's element `surface`. */
enum rmap_true_kind {
    RMAP_TRUE_NONE, /* triangles alone */
    RMAP_TRUE_PLANE,
    RMAP_TRUE_CYLINDER,
    RMAP_TRUE_CONE,
    RMAP_TRUE_SPHERE,
    RMAP_TRUE_TORUS
};

struct rmap_true_surface {
    enum rmap_true_kind kind;
    struct rmap_vec3 at;         /* on the plane or axis; the middle of a sphere or torus */
    struct rmap_vec3 x, y, axis; /* right-handed and orthonormal */
    double radius;               /* of a cone: at z = 0; of a torus: of its middle circle */
    double second;               /* CONE: dr / dz; TORUS: the tube's radius */
};

/* Not merely alike: faces of one surface have the same numbers. */
static inline bool rmap_true_same(const struct rmap_true_surface *a,
                                  const struct rmap_true_surface *b)
{
    return a->kind == b->kind && a->at.x == b->at.x && a->at.y == b->at.y && a->at.z == b->at.z &&
           a->axis.x == b->axis.x && a->axis.y == b->axis.y && a->axis.z == b->axis.z &&
           a->radius == b->radius && a->second == b->second;
}

#define RMAP_TRUE_ROOTS 4

struct rmap_true_meeting {
    int n;
    double t[RMAP_TRUE_ROOTS];               /* in increasing order */
    struct rmap_vec3 point[RMAP_TRUE_ROOTS]; /* in the mesh's frame */
};

static inline struct rmap_vec3 rmap_true_turned(const struct rmap_true_surface *s,
                                                struct rmap_vec3 v)
{
    return rmap_vec3(rmap_dot(s->x, v), rmap_dot(s->y, v), rmap_dot(s->axis, v));
}

static inline struct rmap_vec3 rmap_true_back(const struct rmap_true_surface *s, struct rmap_vec3 v)
{
    return rmap_axpy(v.z, s->axis, rmap_axpy(v.y, s->y, rmap_scale(s->x, v.x)));
}

static inline struct rmap_quadric rmap_true_quadric(const struct rmap_true_surface *s)
{
    double m = s->kind == RMAP_TRUE_CONE ? s->second : 0;
    double gamma = s->kind == RMAP_TRUE_SPHERE ? 1 : -m * m;
    double apex = s->kind == RMAP_TRUE_CONE && m != 0 ? -s->radius / m : 0;
    return (struct rmap_quadric){1, gamma, -m * s->radius, -s->radius * s->radius, apex};
}

/* Is a point, in the surface's frame, on the half of the cone that counts? */
static inline bool rmap_true_sheet(const struct rmap_true_surface *s, double z)
{
    return s->kind != RMAP_TRUE_CONE || s->radius + s->second * z >= 0;
}

static inline void rmap_true_add(const struct rmap_true_surface *s, double t, struct rmap_vec3 p,
                                 struct rmap_true_meeting *to)
{
    if (!rmap_true_sheet(s, p.z))
        return;
    to->t[to->n] = t;
    to->point[to->n++] = rmap_add(s->at, rmap_true_back(s, p));
}

/* own: the origin lies on it, and is none of the points. */
static inline void rmap_true_meet(const struct rmap_true_surface *s, struct rmap_vec3 origin,
                                  struct rmap_vec3 direction, bool own,
                                  struct rmap_true_meeting *to)
{
    struct rmap_vec3 p = rmap_true_turned(s, rmap_sub(origin, s->at));
    struct rmap_vec3 d = rmap_true_turned(s, direction);
    to->n = 0;
    if (s->kind == RMAP_TRUE_PLANE) {
        double t = -p.z / d.z;
        if (!own && d.z != 0)
            rmap_true_add(s, t, rmap_vec3(p.x + t * d.x, p.y + t * d.y, 0), to);
    } else if (s->kind == RMAP_TRUE_TORUS) {
        double t[RMAP_TORUS_DEGREE];
        int n = rmap_torus_roots(s->radius, s->second, p, d, own, t);
        for (int i = 0; i < n; i++)
            rmap_true_add(s, t[i], rmap_axpy(t[i], d, p), to);
    } else if (s->kind != RMAP_TRUE_NONE) {
        const struct rmap_quadric f = rmap_true_quadric(s);
        if (own) {
            double t = rmap_quadric_other(&f, p, d);
            if (t - t == 0)
                rmap_true_add(s, t, rmap_axpy(t, d, p), to);
            return;
        }
        const struct rmap_quadric_roots roots = rmap_quadric_meet(&f, p, d);
        if (roots.missed != 0.0)
            return;
        rmap_true_add(s, roots.shift + roots.t0, rmap_axpy(roots.t0, d, roots.near), to);
        if (roots.t1 > roots.t0)
            rmap_true_add(s, roots.shift + roots.t1, rmap_axpy(roots.t1, d, roots.near), to);
    }
}

/* Of the points ahead of `behind` the one nearest to `middle`; -1: there is none. */
static inline int rmap_true_choose(const struct rmap_true_meeting *met, double behind,
                                   struct rmap_vec3 middle)
{
    double least = HUGE_VAL;
    int best = -1;
    for (int i = 0; i < met->n; i++) {
        struct rmap_vec3 off = rmap_sub(met->point[i], middle);
        double square = rmap_dot(off, off);
        if (met->t[i] > behind && square < least) {
            least = square;
            best = i;
        }
    }
    return best;
}

/* Distance of a point near the surface from it, < 0 on the side of the axis or against it; *normal:
 * unit, the way it grows. */
static inline double rmap_true_distance(const struct rmap_true_surface *s, struct rmap_vec3 point,
                                        struct rmap_vec3 *normal)
{
    struct rmap_vec3 p = rmap_true_turned(s, rmap_sub(point, s->at)), n = rmap_vec3(0, 0, 1);
    double rho = sqrt(p.x * p.x + p.y * p.y), some = rho > 0 ? rho : 1.0, distance = p.z;
    double cosine = 1, sine = 0, off = rho - s->radius;
    if (s->kind == RMAP_TRUE_SPHERE) {
        double r = rmap_length(p);
        n = r > 0 ? rmap_scale(p, 1 / r) : n;
        distance = r - s->radius;
    } else if (s->kind == RMAP_TRUE_TORUS) {
        double r = sqrt(off * off + p.z * p.z), scale = r > 0 ? 1 / r : 0;
        n = rmap_vec3(off * scale * p.x / some, off * scale * p.y / some, p.z * scale);
        distance = r - s->second;
    } else if (s->kind != RMAP_TRUE_PLANE) {
        if (s->kind == RMAP_TRUE_CONE) {
            cosine = 1 / sqrt(1 + s->second * s->second);
            sine = -s->second * cosine;
        }
        distance = off * cosine + p.z * sine;
        n = rmap_vec3(cosine * p.x / some, cosine * p.y / some, sine);
    }
    *normal = rmap_true_back(s, n);
    return distance;
}

/* Unit normal at a point of it, on the side of `flat`. */
static inline struct rmap_vec3 rmap_true_normal(const struct rmap_true_surface *s,
                                                struct rmap_vec3 point, struct rmap_vec3 flat)
{
    struct rmap_vec3 n;
    (void)rmap_true_distance(s, point, &n);
    return rmap_scale(n, rmap_dot(n, flat) < 0 ? -1.0 : 1.0);
}

#endif
