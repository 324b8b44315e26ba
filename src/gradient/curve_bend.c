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

/* The same of four D. */
static inline void across_four(const double (*D)[4], struct rmap_vec3 along, double inverse_square,
                               double of[4])
{
    rmap_wide x = {D[0][0], D[1][0], D[2][0], D[3][0]};
    rmap_wide y = {D[0][1], D[1][1], D[2][1], D[3][1]};
    rmap_wide z = {D[0][2], D[1][2], D[2][2], D[3][2]};
    rmap_wide part = x * along.x + y * along.y + z * along.z;
    rmap_wide square = x * x + y * y + z * z - part * part * inverse_square;
    rmap_wide_store(&square, of);
}

RMAP_WIDE
double rmap_curve_bend(const struct rmap_curve_step *step)
{
    const struct rmap_curve_state *from = &step->from, *to = &step->to;
    double first = across(from->D, from->T, 1.0 / rmap_dot(from->T, from->T));
    double last = across(to->D, to->T, 1.0 / rmap_dot(to->T, to->T));
    double most = rmap_max(0.0, rmap_max(first, last));
    struct rmap_vec3 way = rmap_sub(to->r, from->r);
    double inverse_square = 1.0 / rmap_dot(way, way);
    /* a way of no length: NaN, passed over */
    if (step->pair) {
        double inner[4];
        across_four(&step->D[step->pair->inner], way, inverse_square, inner);
        for (int i = 0; i < 4; i++)
            most = rmap_max(inner[i], most);
    }
    for (int i = 1; !step->pair && i < step->n_stage; i++) {
        const double *D = step->D[i];
        most = rmap_max(across(rmap_vec3(D[0], D[1], D[2]), way, inverse_square), most);
    }
    return MARGIN * sqrt(most);
}
