/* SPDX-License-Identifier: MIT
 *
 * The scheme of Sharma, Kumar, Ghatak 1982 (Appl. Opt. 21, 984, doi:10.1364/AO.21.000984): order 4
 * with three evaluations, of which the first is known from the step before. Between the ends: the
 * polynomial of degree 5 with their r, T and D.
 */
#include "gradient/curve_internal.h"

RMAP_WIDE
void rmap_curve_hermite_finish(struct rmap_curve_step *step)
{
    const struct rmap_curve_state *a = &step->from;
    const struct rmap_curve_state *b = &step->to;
    double h = step->h;
    double square = 1.0 / (h * h);
    /* What the parabola from the start misses at the end, over h^2: in place, h T, h^2 D. */
    struct rmap_vec3 chord = rmap_axpy(-h, a->T, rmap_sub(b->r, a->r));
    struct rmap_vec3 p0 = rmap_axpy(-0.5, a->D, rmap_scale(chord, square));
    struct rmap_vec3 p1 = rmap_sub(rmap_scale(rmap_sub(b->T, a->T), 1.0 / h), a->D);
    struct rmap_vec3 p2 = rmap_sub(b->D, a->D);
    const struct rmap_vec3 bend[] = {
        rmap_scale(a->D, 0.5),
        rmap_axpy(0.5, p2, rmap_axpy(-4.0, p1, rmap_scale(p0, 10.0))),
        rmap_axpy(-1.0, p2, rmap_axpy(7.0, p1, rmap_scale(p0, -15.0))),
        rmap_axpy(0.5, p2, rmap_axpy(-3.0, p1, rmap_scale(p0, 6.0))),
    };
    const int n = (int)(sizeof bend / sizeof bend[0]);
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_wide wide = {0};
        if (k < n)
            rmap_wide_set(&wide, bend[k]);
        rmap_curve_set_bend(step, k, &wide);
    }
    step->whole = h;
    step->pair = NULL;
    step->closed = false;
    step->n_stage = 0;
    rmap_curve_measure(step);
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
    rmap_curve_hermite_finish(step);
    return true;
}
