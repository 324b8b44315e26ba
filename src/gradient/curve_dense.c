/* SPDX-License-Identifier: MIT
 *
 * Dense output of the steps of any scheme.
 */
#include "gradient/curve_internal.h"

RMAP_WIDE
void rmap_curve_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                   struct rmap_vec3 *T)
{
    double t = theta * step->h;
    double share = t / step->whole;
    rmap_wide shares = {share, share, share, share};
    rmap_wide of_r = {0}, of_T = {0};
    for (int k = RMAP_CURVE_POWERS - 1; k >= 0; k--) {
        rmap_wide_horner(&shares, step->bend[k], &of_r);
        rmap_wide_horner(&shares, step->turn[k], &of_T);
    }
    *r = rmap_axpy(t * t, rmap_wide_vec3(&of_r), rmap_axpy(t, step->from.T, step->from.r));
    *T = rmap_axpy(t, rmap_wide_vec3(&of_T), step->from.T);
}

/* from + t of for four t at once */
static inline void abreast(const rmap_wide *t, double from, rmap_wide *of)
{
    *of = from + *of * *t;
}

/* |T|^2 at four places, in t and as shares of the whole step, at once. */
static inline void squares(const struct rmap_curve_step *step, const rmap_wide *t,
                           const rmap_wide *share, rmap_wide *square)
{
    rmap_wide x = {0}, y = {0}, z = {0};
    for (int k = RMAP_CURVE_POWERS - 1; k >= 0; k--) {
        abreast(share, step->turn[k][0], &x);
        abreast(share, step->turn[k][1], &y);
        abreast(share, step->turn[k][2], &z);
    }
    abreast(t, step->from.T.x, &x);
    abreast(t, step->from.T.y, &y);
    abreast(t, step->from.T.z, &z);
    *square = x * x + y * y + z * z;
}

/* Gauss's formula of six points with n = |T| of the dense output: n^2 and n are rougher functions
 * of t than r and T are, and here they cost no evaluation. */
RMAP_WIDE
void rmap_curve_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                        double *length)
{
    static const double node[] = {0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
    static const double weight[] = {0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
    double half = 0.5 * theta, place[8], square[8];
    for (int i = 0; i < 8; i++)
        place[i] = i < 3 ? half - half * node[i % 3] : half + half * node[i % 3];
    for (int i = 0; i < 8; i += 4) {
        rmap_wide t, share, four;
        memcpy(&t, &place[i], sizeof t);
        t = t * step->h;
        share = t / step->whole;
        squares(step, &t, &share, &four);
        memcpy(&square[i], &four, sizeof four);
    }
    *optical = *length = 0.0;
    for (int i = 0; i < 6; i++) {
        double share = half * step->h * weight[i % 3];
        *optical += share * square[i];
        *length += share * sqrt(square[i]);
    }
}

/* The dense output's end made a step of its own, T improved where that has a need. */
static void cut_dense(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    struct rmap_curve_step whole = *step;
    struct rmap_curve_state *to = &step->to;
    rmap_curve_at(&whole, theta, &to->r, &to->T);
    rmap_curve_lengths(&whole, theta, &step->optical, &step->length);
    if (whole.pair && whole.pair->has_finer && whole.between > 1.0) {
        (void)rmap_curve_nystrom_finer(curve, &whole, theta, &to->T);
    }
    if (!rmap_curve_evaluate(curve, to)) { /* the edge of the field, within rounding */
        to->n = rmap_length(to->T);
    }
    to->T = rmap_scale(to->T, to->n / rmap_length(to->T));
    step->h = theta * whole.h;
}

/* The step taken anew to there, where dense output would be too coarse. */
static bool cut_anew(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    if (!step->pair) {
        return rmap_curve_sharma(curve, step, theta * step->h);
    }
    if (step->pair->has_finer || step->between <= 1.0) {
        return false;
    }
    struct rmap_curve_step shorter = *step;
    if (!rmap_curve_nystrom(curve, step->pair, &shorter, theta * step->h)) {
        return false;
    }
    (void)rmap_curve_nystrom_error(curve, &shorter);
    rmap_curve_nystrom_finish(&shorter);
    *step = shorter;
    return true;
}

bool rmap_curve_cut(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    if (theta < 1.0 && !cut_anew(curve, step, theta)) {
        cut_dense(curve, step, theta);
    }
    curve->state = step->to;
    return true;
}

static double distance_to_chord(struct rmap_vec3 p, struct rmap_vec3 a, struct rmap_vec3 b)
{
    struct rmap_vec3 ab = rmap_sub(b, a);
    struct rmap_vec3 ap = rmap_sub(p, a);
    double square = rmap_dot(ab, ab);
    double along = square > 0.0 ? fmin(fmax(rmap_dot(ap, ab) / square, 0.0), 1.0) : 0.0;
    return rmap_length(rmap_axpy(-along, ab, ap));
}

double rmap_curve_sag(const struct rmap_curve_step *step, double theta0, double theta1)
{
    enum { PARTS = 4 };
    struct rmap_vec3 p[PARTS + 1];
    struct rmap_vec3 T;
    double sag = 0.0;
    for (int i = 0; i <= PARTS; i++) {
        rmap_curve_at(step, theta0 + (theta1 - theta0) * i / PARTS, &p[i], &T);
    }
    for (int i = 1; i < PARTS; i++) {
        sag = fmax(sag, distance_to_chord(p[i], p[0], p[PARTS]));
    }
    return 1.05 * sag; /* between the samples */
}
