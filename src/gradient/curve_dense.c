/* SPDX-License-Identifier: MIT
 *
 * Dense output of the steps of any scheme.
 */
#include "gradient/curve_internal.h"

void rmap_curve_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                   struct rmap_vec3 *T)
{
    if (step->n_stage) {
        rmap_curve_nystrom_at(step, theta, r, T);
    } else {
        rmap_curve_hermite_at(step, theta, r, T);
    }
}

void rmap_curve_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                        double *length)
{
    if (step->n_stage) {
        rmap_curve_nystrom_lengths(step, theta, optical, length);
    } else {
        rmap_curve_hermite_lengths(step, theta, optical, length);
    }
}

/* The dense output's end made a step of its own. */
static void cut_dense(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    struct rmap_curve_step whole = *step;
    struct rmap_curve_state *to = &step->to;
    rmap_curve_at(&whole, theta, &to->r, &to->T);
    rmap_curve_lengths(&whole, theta, &step->optical, &step->length);
    if (!rmap_curve_evaluate(curve, to)) { /* the edge of the field, within rounding */
        to->n = rmap_length(to->T);
    }
    to->T = rmap_scale(to->T, to->n / rmap_length(to->T));
    step->h = theta * whole.h;
}

bool rmap_curve_cut(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    bool adaptive = step->n_stage > 0;
    if (theta < 1.0) {
        if (adaptive || !rmap_curve_sharma(curve, step, theta * step->h)) {
            cut_dense(curve, step, theta);
        }
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
