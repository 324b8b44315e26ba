/* SPDX-License-Identifier: MIT
 *
 * Steps of the Runge-Kutta-Nystroem pairs and their errors.
 */
#include "gradient/curve_internal.h"

static struct rmap_vec3 combine(const double *weight, const struct rmap_vec3 *D, int count)
{
    struct rmap_vec3 sum = {0};
    for (int i = 0; i < count; i++) {
        sum = rmap_axpy(weight[i], D[i], sum);
    }
    return sum;
}

bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct rmap_curve_state at;
    step->h = step->whole = h;
    step->pair = pair;
    step->n_stage = pair->stages;
    step->D[0] = from->D;
    for (int i = 1; i < pair->stages; i++) {
        struct rmap_vec3 bend = combine(pair->coupling[i], step->D, i);
        at.r = rmap_axpy(h * h, bend, rmap_axpy(pair->node[i] * h, from->T, from->r));
        if (!rmap_curve_evaluate(curve, &at)) {
            return false;
        }
        step->D[i] = at.D;
    }
    at.T = rmap_axpy(h, combine(pair->weight_T, step->D, pair->stages), from->T);
    step->to = at;
    return true;
}

/* The embedded defect is the error of the lower order, far more than that of the step. As in
 * Hairer, Norsett, Wanner 1993 (Solving Ordinary Differential Equations I, sec. II.10, eq. 10.17)
 * it is brought down by its ratio to a still lower order, where that ratio is small: in a smooth
 * field; at kinks all orders are alike and the defect stands. */
double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_curve_pair *pair = step->pair;
    double h = step->h;
    double place = h * rmap_length(combine(pair->defect_r, step->D, pair->stages));
    double turn = rmap_length(combine(pair->defect_T, step->D, pair->stages));
    double rough = rmap_length(combine(pair->rough, step->D, pair->stages));
    double rougher = rmap_length(combine(pair->rougher, step->D, pair->stages));
    double fall = pair->smoothness * turn;
    if (rougher > 0.0) {
        fall = fmax(fall, pair->smoothness * rough * rough / rougher);
    }
    double share = fall < rough ? fall / rough : 1.0;
    double angle = turn / step->to.n * gradient->size;
    step->error = share * h * place;
    step->between = sqrt(share) * h * angle / gradient->options.tolerance;
    return fmax(step->error, share * h * angle) / gradient->options.tolerance;
}

void rmap_curve_nystrom_finish(struct rmap_curve_step *step)
{
    const struct rmap_curve_pair *pair = step->pair;
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        step->bend[k] = combine(pair->dense[k], step->D, pair->stages);
    }
    rmap_curve_lengths(step, 1.0, &step->optical, &step->length);
}

bool rmap_curve_nystrom_finer(struct rmap_curve *curve, const struct rmap_curve_step *step,
                              double theta, struct rmap_vec3 *T)
{
    struct rmap_curve_state middle;
    double t = theta * step->h;
    struct rmap_vec3 sum = {0};
    rmap_curve_at(step, 0.5 * step->whole / step->h, &middle.r, &middle.T);
    if (!rmap_curve_evaluate(curve, &middle)) {
        return false;
    }
    for (int k = RMAP_CURVE_POWERS; k >= 0; k--) {
        const double *finer = step->pair->finer[k];
        struct rmap_vec3 bend = rmap_axpy(finer[RMAP_CURVE_STAGES], middle.D,
                                          combine(finer, step->D, RMAP_CURVE_STAGES));
        sum = rmap_axpy(k + 2, bend, rmap_scale(sum, t / step->whole));
    }
    *T = rmap_axpy(t, sum, step->from.T);
    return true;
}
