/* SPDX-License-Identifier: MIT
 *
 * The scheme of Sharma, Kumar, Ghatak 1982 (Appl. Opt. 21, 984, doi:10.1364/AO.21.000984): order 4
 * with three evaluations, of which the first is known from the step before. Between the ends: the
 * polynomial of degree 5 with their r, T and D.
 */
#include "gradient/curve_internal.h"

/* The integrals of n^2 and n from their values and derivatives at the ends: order 4. */
static double hermite_integral(double theta, double f0, double f1, double g0, double g1)
{
    double t = theta;
    double t2 = t * t;
    double t3 = t2 * t;
    double t4 = t2 * t2;
    return f0 * (t - t3 + t4 / 2) + f1 * (t3 - t4 / 2) + g0 * (t2 / 2 - 2 * t3 / 3 + t4 / 4) +
           g1 * (t4 / 4 - t3 / 3);
}

void rmap_curve_hermite_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                                double *length)
{
    const struct rmap_curve_state *a = &step->from;
    const struct rmap_curve_state *b = &step->to;
    double h = step->h;
    double ga = h * rmap_dot(a->D, a->T); /* h/2 d(n^2)/dt */
    double gb = h * rmap_dot(b->D, b->T);
    *optical = h * hermite_integral(theta, a->n * a->n, b->n * b->n, 2 * ga, 2 * gb);
    *length = h * hermite_integral(theta, a->n, b->n, ga / a->n, gb / b->n);
}

void rmap_curve_hermite_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                           struct rmap_vec3 *T)
{
    const struct rmap_curve_state *a = &step->from;
    const struct rmap_curve_state *b = &step->to;
    double h = step->h;
    double t = theta;
    double t2 = t * t;
    double t3 = t2 * t;
    double bend = h * h / 2;
    /* What the parabola from the start misses at the end: in place, in h T, in h^2 D. */
    struct rmap_vec3 p0 =
        rmap_sub(rmap_sub(b->r, a->r), rmap_axpy(bend, a->D, rmap_scale(a->T, h)));
    struct rmap_vec3 p1 = rmap_scale(rmap_sub(rmap_sub(b->T, a->T), rmap_scale(a->D, h)), h);
    struct rmap_vec3 p2 = rmap_scale(rmap_sub(b->D, a->D), h * h);
    /* sum of c[k] t^(3 + k) with value p0, slope p1, second derivative p2 at 1 */
    struct rmap_vec3 c0 = rmap_axpy(0.5, p2, rmap_axpy(-4.0, p1, rmap_scale(p0, 10.0)));
    struct rmap_vec3 c1 = rmap_axpy(-1.0, p2, rmap_axpy(7.0, p1, rmap_scale(p0, -15.0)));
    struct rmap_vec3 c2 = rmap_axpy(0.5, p2, rmap_axpy(-3.0, p1, rmap_scale(p0, 6.0)));
    struct rmap_vec3 rest = rmap_axpy(t2, c2, rmap_axpy(t, c1, c0));
    struct rmap_vec3 slope = rmap_axpy(5 * t2, c2, rmap_axpy(4 * t, c1, rmap_scale(c0, 3.0)));
    *r = rmap_axpy(t3, rest, rmap_axpy(bend * t2, a->D, rmap_axpy(t * h, a->T, a->r)));
    *T = rmap_axpy(t2 / h, slope, rmap_axpy(h * t, a->D, a->T));
}

bool rmap_curve_sharma(struct rmap_curve *curve, struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct rmap_vec3 A = rmap_scale(from->D, h);
    struct rmap_curve_state at;
    at.r = rmap_axpy(h / 8, A, rmap_axpy(h / 2, from->T, from->r));
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    struct rmap_vec3 B = rmap_scale(at.D, h);
    at.r = rmap_axpy(h / 2, B, rmap_axpy(h, from->T, from->r));
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    struct rmap_vec3 C = rmap_scale(at.D, h);
    struct rmap_vec3 mean = rmap_scale(rmap_axpy(2.0, B, A), 1.0 / 6.0);
    struct rmap_vec3 turn = rmap_scale(rmap_add(rmap_axpy(4.0, B, A), C), 1.0 / 6.0);
    at.r = rmap_axpy(h, rmap_add(from->T, mean), from->r);
    at.T = rmap_add(from->T, turn);
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    step->to = at;
    step->h = h;
    step->n_stage = 0;
    rmap_curve_hermite_lengths(step, 1.0, &step->optical, &step->length);
    step->error = step->length * fabs(rmap_length(at.T) - at.n) / at.n; /* the invariant's drift */
    return true;
}
