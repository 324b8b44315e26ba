/* SPDX-License-Identifier: MIT
 *
 * Index fields with known rays, made by hand, and media of them in place. Include after cmocka.h.
 */
#ifndef HAND_FIELD_H
#define HAND_FIELD_H

#include <math.h>

#include "gradient/curve.h"

/* n^2 = a + b.p + c |p|^2 - q (x^2 + y^2): rays are sines, or parabolas, in t. */
struct hand_field {
    struct rmap_field field;
    double a, c, q;
    struct rmap_vec3 b;
};

static bool hand_square_at(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                           double *n, struct rmap_vec3 *gradient)
{
    const struct hand_field *f = (const struct hand_field *)field;
    (void)channel;
    double square =
        f->a + rmap_dot(f->b, p) + f->c * rmap_dot(p, p) - f->q * (p.x * p.x + p.y * p.y);
    if (!(square > 0.0)) {
        return false;
    }
    *n = sqrt(square);
    struct rmap_vec3 half = rmap_axpy(f->c, p, rmap_scale(f->b, 0.5));
    half = rmap_axpy(-f->q, rmap_vec3(p.x, p.y, 0.0), half);
    *gradient = rmap_scale(half, 1.0 / *n);
    return true;
}

/* Maxwell's fish-eye, n = 2 / (1 + r^2): circles. */
static bool hand_fisheye_at(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                            double *n, struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    double s = 1.0 + rmap_dot(p, p);
    *n = 2.0 / s;
    *gradient = rmap_scale(p, -4.0 / (s * s));
    return true;
}

/* Eaton's lens, n^2 = 2 / r - 1: Kepler's ellipses. */
static bool hand_eaton_at(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *n, struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    double r = rmap_length(p);
    double square = 2.0 / r - 1.0;
    if (!(square > 0.0 && isfinite(square))) {
        return false;
    }
    *n = sqrt(square);
    *gradient = rmap_scale(p, -1.0 / (r * r * r * *n));
    return true;
}

/* n = 1.5 for z < 0; from there on rising by 0.3 per unit: the gradient jumps. */
static bool hand_bend_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                         struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    *n = p.z < 0.0 ? 1.5 : 1.5 + 0.3 * p.z;
    *gradient = rmap_vec3(0.0, 0.0, p.z < 0.0 ? 0.0 : 0.3);
    return true;
}

/* n = 1.5 + 0.2 z up to z = 1, nothing beyond: the edge of a grid. */
static bool hand_edge_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                         struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    *n = 1.5 + 0.2 * p.z;
    *gradient = rmap_vec3(0.0, 0.0, 0.2);
    return p.z <= 1.0;
}

static const struct rmap_field_ops hand_edge = {.model = "edge", .at = hand_edge_at};
static const struct rmap_field_ops hand_square = {.model = "square", .at = hand_square_at};
static const struct rmap_field_ops hand_fisheye = {.model = "fish-eye", .at = hand_fisheye_at};
static const struct rmap_field_ops hand_eaton = {.model = "eaton", .at = hand_eaton_at};
static const struct rmap_field_ops hand_bend = {.model = "bend", .at = hand_bend_at};

static inline struct hand_field hand_luneburg(void)
{
    return (struct hand_field){.field = {.ops = &hand_square, .n_channel = 1}, .a = 2.0, .c = -1.0};
}

/* n^2 = n0^2 (1 - alpha^2 (x^2 + y^2)) */
static inline struct hand_field hand_rod(double n0, double alpha)
{
    return (struct hand_field){
        .field = {.ops = &hand_square, .n_channel = 1}, .a = n0 * n0, .q = n0 * n0 * alpha * alpha};
}

static inline struct hand_field hand_other(const struct rmap_field_ops *ops)
{
    return (struct hand_field){.field = {.ops = ops, .n_channel = 1}};
}

/* In place at the origin, with the options' defaults of a body of that size. */
static inline struct rmap_gradient hand_gradient(const struct hand_field *field, double size,
                                                 double tolerance)
{
    return (struct rmap_gradient){
        .field = &field->field,
        .to_world = rmap_affine_identity(),
        .to_local = rmap_affine_identity(),
        .size = size,
        .options = {.scheme = RMAP_SCHEME_ADAPTIVE,
                    .tolerance = tolerance,
                    .sag = 1e-2 * size,
                    .polyline = 1e-3 * size,
                    .step_min = 1e-4 * size,
                    .step_max = 1e-2 * size,
                    .step = 1e-2 * size,
                    .amplitude = 1.0 / size,
                    .max_steps = 1000000},
    };
}

#endif
