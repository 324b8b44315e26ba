/* SPDX-License-Identifier: MIT
 *
 * Steps of the Runge-Kutta-Nystroem pairs and their errors.
 */
#include "gradient/curve_internal.h"

/* The stages' D, four abreast. */
struct stages {
    rmap_wide D[RMAP_CURVE_STAGES];
};

static inline void take(struct stages *stages, int i, struct rmap_vec3 D)
{
    stages->D[i] = (rmap_wide){D.x, D.y, D.z, 0.0};
}

static inline void take_all(struct stages *stages, const struct rmap_curve_step *step)
{
    for (int i = 0; i < step->n_stage; i++)
        take(stages, i, step->D[i]);
}

static inline struct rmap_vec3 combine(const double *weight, const struct stages *stages, int count)
{
    rmap_wide sum = {0};
    for (int i = 0; i < count; i++)
        rmap_wide_axpy(weight[i], &stages->D[i], &sum);
    return rmap_wide_vec3(&sum);
}

RMAP_WIDE
bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct rmap_curve_state at;
    struct stages stages;
    step->h = step->whole = h;
    step->pair = pair;
    step->n_stage = pair->stages;
    step->D[0] = from->D;
    take(&stages, 0, from->D);
    for (int i = 1; i < pair->stages; i++) {
        struct rmap_vec3 bend = combine(pair->coupling[i], &stages, i);
        at.r = rmap_axpy(h * h, bend, rmap_axpy(pair->node[i] * h, from->T, from->r));
        if (!rmap_curve_evaluate(curve, &at)) {
            return false;
        }
        step->D[i] = at.D;
        take(&stages, i, at.D);
    }
    at.T = rmap_axpy(h, combine(pair->weight_T, &stages, pair->stages), from->T);
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
    struct stages stages;
    take_all(&stages, step);
    double place = h * rmap_length(combine(pair->defect_r, &stages, pair->stages));
    double turn = rmap_length(combine(pair->defect_T, &stages, pair->stages));
    double rough = rmap_length(combine(pair->rough, &stages, pair->stages));
    double rougher = rmap_length(combine(pair->rougher, &stages, pair->stages));
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

RMAP_WIDE
void rmap_curve_nystrom_finish(struct rmap_curve_step *step)
{
    const struct rmap_curve_pair *pair = step->pair;
    struct stages stages;
    take_all(&stages, step);
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_curve_set_bend(step, k, combine(pair->dense[k], &stages, pair->stages));
    }
    rmap_curve_lengths(step, 1.0, &step->optical, &step->length);
}

RMAP_WIDE
bool rmap_curve_nystrom_finer(struct rmap_curve *curve, const struct rmap_curve_step *step,
                              double theta, struct rmap_vec3 *T)
{
    struct rmap_curve_state middle;
    double t = theta * step->h;
    struct rmap_vec3 sum = {0};
    struct stages stages;
    take_all(&stages, step);
    rmap_curve_at(step, 0.5 * step->whole / step->h, &middle.r, &middle.T);
    if (!rmap_curve_evaluate(curve, &middle)) {
        return false;
    }
    for (int k = RMAP_CURVE_POWERS; k >= 0; k--) {
        const double *finer = step->pair->finer[k];
        struct rmap_vec3 bend = rmap_axpy(finer[RMAP_CURVE_STAGES], middle.D,
                                          combine(finer, &stages, RMAP_CURVE_STAGES));
        sum = rmap_axpy(k + 2, bend, rmap_scale(sum, t / step->whole));
    }
    *T = rmap_axpy(t, sum, step->from.T);
    return true;
}
