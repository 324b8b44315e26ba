/* SPDX-License-Identifier: MIT
 *
 * Light through a gradient medium: the eikonal equation in optical-ray form (Sharma, Kumar, Ghatak
 * 1982, doi:10.1364/AO.21.000984),
 *     d2r/dt2 = D(r) = 1/2 grad n^2,   T = dr/dt = n dr/ds,   dt = ds / n,
 * step by step, with dense output. World frame. No surfaces here: the tracer tests the curve
 * against the scene. |T| = n is an invariant.
 */
#ifndef RMAP_CURVE_H
#define RMAP_CURVE_H

#include <stdbool.h>
#include <stdint.h>

#include "gradient/gradient.h"

/* A point of the curve. */
struct rmap_curve_state {
    struct rmap_vec3 r, T, D;
    double n; /* of the field at r */
};

/* Stages whose values a step keeps for its dense output. */
#define RMAP_CURVE_STAGES 6

/* One step; its curve is r(theta), theta in [0, 1]. */
struct rmap_curve_step {
    struct rmap_curve_state from, to;
    double h;               /* in t */
    double optical, length; /* over the step: integrals of n^2 dt, of n dt; as accurate as r */
    double error;           /* estimate of the error of `to` over this step, scene units */

    int n_stage;  /* of the dense output; 0: from the ends alone */
    double whole; /* h of the step that the stages are of */
    struct rmap_vec3 D[RMAP_CURVE_STAGES];
    double n[RMAP_CURVE_STAGES];
};

struct rmap_curve {
    const struct rmap_gradient *gradient; /* borrowed */
    int channel;
    struct rmap_curve_state state; /* where the next step begins */
    double next_h;                 /* guess for the next step */
    uint64_t n_evaluation;         /* of the field, so far */
    uint64_t n_step;
    double log_error; /* of the last step against the tolerance, for the step control */
    bool blind;       /* the last step ended where the field has no value */
};

/* From a point in a unit direction. False where the field has no value. */
bool rmap_curve_begin(struct rmap_curve *curve, const struct rmap_gradient *gradient, int channel,
                      struct rmap_vec3 origin, struct rmap_vec3 direction);

/* The next step: no longer than length_max (geometric, about). The curve's state moves to its end.
 * False where the field has no value within reach of any step (the state stays). */
bool rmap_curve_advance(struct rmap_curve *curve, double length_max, struct rmap_curve_step *step);

/* Dense output, no evaluation: position and T at theta, within the tolerance. */
void rmap_curve_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                   struct rmap_vec3 *T);

/* Ends the step at theta, as accurately as a step that had been taken to there: may evaluate.
 * step->to, optical and length are of the shorter step; the curve's state is its end. */
bool rmap_curve_cut(struct rmap_curve *curve, struct rmap_curve_step *step, double theta);

/* Integrals from the step's start to theta from the dense output (for detectors on the way). */
void rmap_curve_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                        double *length);

/* Most that the chord from theta0 to theta1 leaves the curve; an upper bound to 10 %. */
double rmap_curve_sag(const struct rmap_curve_step *step, double theta0, double theta1);

#endif
