/* SPDX-License-Identifier: MIT */
#include "gradient/curve.h"

/* Between the stages. */
#define MARGIN 1.1

static double across(struct rmap_vec3 D, struct rmap_vec3 T)
{
    double along = rmap_dot(D, T) / rmap_dot(T, T);
    struct rmap_vec3 rest = rmap_axpy(-along, T, D);
    return rmap_dot(rest, rest);
}

double rmap_curve_bend(const struct rmap_curve_step *step)
{
    double most = fmax(across(step->from.D, step->from.T), across(step->to.D, step->to.T));
    struct rmap_vec3 way = rmap_sub(step->to.r, step->from.r);
    for (int i = 1; i < step->n_stage; i++) {
        double square = across(step->D[i], way);
        most = square > most ? square : most;
    }
    return MARGIN * sqrt(most);
}
