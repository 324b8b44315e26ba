/* SPDX-License-Identifier: MIT */
#include "gradient/curve_internal.h"

/* Between the stages. */
#define MARGIN 1.1

/* Square of the part of D across a direction; from its whole square, so good to 1e-8 D alone. */
static double across(struct rmap_vec3 D, struct rmap_vec3 along, double inverse_square)
{
    double part = rmap_dot(D, along);
    return rmap_dot(D, D) - part * part * inverse_square;
}

double rmap_curve_bend(const struct rmap_curve_step *step)
{
    const struct rmap_curve_state *from = &step->from, *to = &step->to;
    double first = across(from->D, from->T, 1.0 / rmap_dot(from->T, from->T));
    double last = across(to->D, to->T, 1.0 / rmap_dot(to->T, to->T));
    double most = rmap_max(0.0, rmap_max(first, last));
    struct rmap_vec3 way = rmap_sub(to->r, from->r);
    double inverse_square = 1.0 / rmap_dot(way, way);
    int begin = step->pair ? step->pair->inner : 1;
    int end = step->pair ? begin + 4 : step->n_stage;
    for (int i = begin; i < end; i++) {
        const double *D = step->D[i];
        /* a way of no length: NaN, passed over */
        most = rmap_max(across(rmap_vec3(D[0], D[1], D[2]), way, inverse_square), most);
    }
    return MARGIN * sqrt(most);
}
