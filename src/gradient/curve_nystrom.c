/* SPDX-License-Identifier: MIT
 *
 * Steps of the Runge-Kutta-Nystroem pairs and their errors.
 */
#include "gradient/curve_internal.h"

/* Sum of the stages' D, weighted. */
static inline void combine(const double *weight, const struct rmap_curve_step *step, int count,
                           rmap_wide *sum)
{
    *sum = (rmap_wide){0};
    for (int i = 0; i < count; i++) {
        rmap_wide D;
        rmap_wide_load(&D, step->D[i]);
        rmap_wide_axpy(weight[i], &D, sum);
    }
}

static inline double length_of(const rmap_wide *a)
{
    return rmap_length(rmap_wide_vec3(a));
}

RMAP_WIDE
bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h)
{
    struct rmap_curve_state at = {.D = step->from.D};
    rmap_wide from_r, from_T, sum, D;
    step->h = step->whole = h;
    step->pair = pair;
    step->n_stage = pair->stages;
    rmap_wide_set(&from_r, step->from.r);
    rmap_wide_set(&from_T, step->from.T);
    rmap_wide_set(&D, step->from.D);
    rmap_wide_store(&D, step->D[0]);
    for (int i = 1; i < pair->stages; i++) {
        rmap_wide r = from_r;
        combine(pair->coupling[i], step, i, &sum);
        rmap_wide_axpy(pair->node[i] * h, &from_T, &r);
        rmap_wide_axpy(h * h, &sum, &r);
        at.r = rmap_wide_vec3(&r);
        if (!rmap_curve_evaluate(curve, &at)) {
            return false;
        }
        rmap_wide_set(&D, at.D);
        rmap_wide_store(&D, step->D[i]);
    }
    combine(pair->weight_T, step, pair->stages, &sum);
    rmap_wide_axpy(h, &sum, &from_T);
    at.T = rmap_wide_vec3(&from_T);
    step->to = at;
    return true;
}

/* The embedded defect is the error of the lower order, far more than that of the step. As in
 * Hairer, Norsett, Wanner 1993 (Solving Ordinary Differential Equations I, sec. II.10, eq. 10.17)
 * it is brought down by its ratio to a still lower order, where that ratio is small: in a smooth
 * field; at kinks all orders are alike and the defect stands. */
RMAP_WIDE
double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_curve_pair *pair = step->pair;
    double h = step->h;
    rmap_wide of_r = {0}, of_T = {0}, of_rough = {0}, of_rougher = {0};
    for (int i = 0; i < pair->stages; i++) {
        rmap_wide D;
        rmap_wide_load(&D, step->D[i]);
        rmap_wide_axpy(pair->defect_r[i], &D, &of_r);
        rmap_wide_axpy(pair->defect_T[i], &D, &of_T);
        rmap_wide_axpy(pair->rough[i], &D, &of_rough);
        rmap_wide_axpy(pair->rougher[i], &D, &of_rougher);
    }
    double place = h * length_of(&of_r), turn = length_of(&of_T);
    double rough = length_of(&of_rough), rougher = length_of(&of_rougher);
    double fall = pair->smoothness * turn;
    if (rougher > 0.0) {
        fall = rmap_max(fall, pair->smoothness * rough * rough / rougher);
    }
    double share = fall < rough ? fall / rough : 1.0;
    double angle = turn / step->to.n * gradient->size;
    step->error = share * h * place;
    step->between = sqrt(share) * h * angle / gradient->options.tolerance;
    return rmap_max(step->error, share * h * angle) / gradient->options.tolerance;
}

RMAP_WIDE
void rmap_curve_nystrom_finish(struct rmap_curve_step *step)
{
    const struct rmap_curve_pair *pair = step->pair;
    rmap_wide bend[RMAP_CURVE_POWERS] = {{0}};
    for (int i = 0; i < pair->stages; i++) {
        rmap_wide D;
        rmap_wide_load(&D, step->D[i]);
        for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
            rmap_wide_axpy(pair->dense[k][i], &D, &bend[k]);
        }
    }
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_curve_set_bend(step, k, &bend[k]);
    }
    rmap_curve_measure(step);
}

RMAP_WIDE
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
        rmap_wide bend;
        combine(finer, step, RMAP_CURVE_STAGES, &bend);
        sum = rmap_axpy(k + 2, rmap_axpy(finer[RMAP_CURVE_STAGES], middle.D, rmap_wide_vec3(&bend)),
                        rmap_scale(sum, t / step->whole));
    }
    *T = rmap_axpy(t, sum, step->from.T);
    return true;
}
