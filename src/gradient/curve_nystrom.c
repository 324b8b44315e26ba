/* SPDX-License-Identifier: MIT
 *
 * Steps of the Runge-Kutta-Nystroem pairs and their errors.
 */
#include "gradient/curve_pairs.h"

/* sum + weight D. A coefficient of 0 costs nothing where it is known. */
RMAP_COPIED void add_stage(double weight, const double D[4], rmap_wide *sum)
{
    rmap_wide of;
    if (weight != 0.0) {
        rmap_wide_load(&of, D);
        rmap_wide_axpy(weight, &of, sum);
    }
}

/* Sum of the stages' D, weighted. */
RMAP_COPIED void combine(const double *weight, const struct rmap_curve_step *step, int count,
                         rmap_wide *sum)
{
    *sum = (rmap_wide){0};
    RMAP_UNROLL
    for (int i = 0; i < count; i++) {
        add_stage(weight[i], step->D[i], sum);
    }
}

static inline double square_of(const rmap_wide *a)
{
    return rmap_dot(rmap_wide_vec3(a), rmap_wide_vec3(a));
}

/* D = n grad n */
static inline bool evaluate(const struct rmap_curve *curve, const rmap_wide *r, double *n,
                            double D[4])
{
    struct rmap_vec3 slope;
    rmap_wide of;
    if (!rmap_gradient_at(curve->gradient, curve->channel, rmap_wide_vec3(r), n, &slope)) {
        return false;
    }
    rmap_wide_set(&of, slope);
    of = of * *n;
    rmap_wide_store(&of, D);
    return true;
}

RMAP_COPIED bool step_with(const struct rmap_curve_pair *pair, int stages, struct rmap_curve *curve,
                           struct rmap_curve_step *step, double h)
{
    rmap_wide from_r, from_T, r, sum;
    step->pair = pair;
    step->n_stage = stages;
    rmap_wide_set(&from_r, step->from.r);
    rmap_wide_set(&from_T, step->from.T);
    rmap_wide_set(&r, step->from.D);
    rmap_wide_store(&r, step->D[0]);
    RMAP_UNROLL
    for (int i = 1; i < stages; i++) {
        combine(pair->coupling[i], step, i, &sum);
        r = from_r;
        rmap_wide_axpy(pair->node[i] * h, &from_T, &r);
        rmap_wide_axpy(h * h, &sum, &r);
        if (!evaluate(curve, &r, &step->to.n, step->D[i])) {
            curve->n_evaluation += (uint64_t)i;
            return false;
        }
    }
    curve->n_evaluation += (uint64_t)pair->evaluations;
    combine(pair->weight_T, step, stages, &sum);
    rmap_wide_axpy(h, &sum, &from_T);
    step->to.r = rmap_wide_vec3(&r);
    step->to.T = rmap_wide_vec3(&from_T);
    const double *D = step->D[stages - 1];
    step->to.D = rmap_vec3(D[0], D[1], D[2]);
    return true;
}

RMAP_WIDE
bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h)
{
    step->h = step->whole = h;
    return pair == &rmap_curve_pair_8 ? step_with(&rmap_curve_pair_8, 9, curve, step, h)
                                      : step_with(&rmap_curve_pair_6, 6, curve, step, h);
}

/* Squares: h times the error of r, the error of T, and what is two and four orders rougher. */
struct defects {
    double place, turn, rough, rougher;
};

RMAP_COPIED struct defects defects_with(const struct rmap_curve_pair *pair, int stages,
                                        const struct rmap_curve_step *step)
{
    rmap_wide of_r, of_T, of_rough, of_rougher;
    combine(pair->defect_r, step, stages, &of_r);
    combine(pair->defect_T, step, stages, &of_T);
    combine(pair->rough, step, stages, &of_rough);
    combine(pair->rougher, step, stages, &of_rougher);
    return (struct defects){square_of(&of_r), square_of(&of_T), square_of(&of_rough),
                            square_of(&of_rougher)};
}

RMAP_COPIED struct defects defects_of(const struct rmap_curve_step *step)
{
    return step->pair == &rmap_curve_pair_8 ? defects_with(&rmap_curve_pair_8, 9, step)
                                            : defects_with(&rmap_curve_pair_6, 6, step);
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
    struct defects square = defects_of(step);
    double of_turn = sqrt(square.turn), of_rough = sqrt(square.rough);
    double of_rougher = sqrt(square.rougher);
    double h = step->h, place = h * sqrt(square.place);
    double fall = pair->smoothness * of_turn;
    if (of_rougher > 0.0) {
        fall = rmap_max(fall, pair->smoothness * of_rough * of_rough / of_rougher);
    }
    double share = fall < of_rough ? fall / of_rough : 1.0;
    double angle = of_turn / step->to.n * gradient->size;
    step->share = share;
    step->angle = angle;
    return rmap_max(share * h * place, share * h * angle) / gradient->options.tolerance;
}

RMAP_WIDE
double rmap_curve_nystrom_error_square(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_curve_pair *pair = step->pair;
    struct defects of = defects_of(step);
    double tolerance = gradient->options.tolerance, n = step->to.n, h2 = step->h * step->h;
    double unit = 1.0 / (tolerance * tolerance), view = gradient->size / n;
    double smooth = pair->smoothness * pair->smoothness, share = smooth * of.turn / of.rough;
    if (of.rougher > 0.0) {
        share = rmap_max(share, smooth * of.rough / of.rougher);
    }
    share = share < 1.0 ? share : 1.0; /* uniform: 0 / 0 */
    double place = h2 * h2 * of.place, angle = h2 * of.turn * (view * view);
    step->share = share;
    step->angle = angle;
    return share * rmap_max(place, angle) * unit;
}

double rmap_curve_nystrom_between(const struct rmap_curve *curve,
                                  const struct rmap_curve_step *step)
{
    double tolerance = curve->gradient->options.tolerance, root = sqrt(step->share);
    if (!step->rough)
        return root * step->whole * step->angle / tolerance;
    double unit = 1.0 / (tolerance * tolerance);
    return sqrt(root * step->angle * unit);
}

RMAP_COPIED void dense_with(const struct rmap_curve_pair *pair, int stages,
                            struct rmap_curve_step *step)
{
    RMAP_UNROLL
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_wide bend;
        combine(pair->dense[k], step, stages, &bend);
        rmap_curve_set_bend(step, k, &bend);
    }
}

RMAP_WIDE
void rmap_curve_nystrom_finish(struct rmap_curve_step *step)
{
    if (step->pair == &rmap_curve_pair_8)
        dense_with(&rmap_curve_pair_8, 9, step);
    else
        dense_with(&rmap_curve_pair_6, 6, step);
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
