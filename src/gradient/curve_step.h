/* SPDX-License-Identifier: MIT
 *
 * What the curve's schemes share: one step each from the curve's state, and its dense output.
 */
#ifndef RMAP_CURVE_STEP_H
#define RMAP_CURVE_STEP_H

#include <stddef.h>

#include <string.h>

#include "base/wide.h"
#include "gradient/curve.h"

/* x, y, z and what comes cheapest, or four of a kind: one operation does them all. By address
 * alone, as what passes them in registers differs from machine to machine. */
typedef double rmap_wide __attribute__((vector_size(32)));

static inline struct rmap_vec3 rmap_wide_vec3(const rmap_wide *a)
{
    return rmap_vec3((*a)[0], (*a)[1], (*a)[2]);
}

static inline void rmap_wide_set(rmap_wide *a, struct rmap_vec3 b)
{
    *a = (rmap_wide){b.x, b.y, b.z, b.z};
}

static inline void rmap_wide_load(rmap_wide *a, const double from[4])
{
    memcpy(a, from, sizeof *a);
}

static inline void rmap_wide_store(const rmap_wide *a, double to[4])
{
    memcpy(to, a, sizeof *a);
}

/* a + s b, elementwise as rmap_axpy */
static inline void rmap_wide_axpy(double s, const rmap_wide *b, rmap_wide *a)
{
    *a = *a + *b * s;
}

/* share a + b: a step of Horner's rule */
static inline void rmap_wide_horner(const rmap_wide *share, const double b[4], rmap_wide *a)
{
    rmap_wide next;
    rmap_wide_load(&next, b);
    *a = next + *a * *share;
}

/* rmap_curve_at with t = theta h and its share of the whole step. */
RMAP_COPIED void rmap_curve_dense(const struct rmap_curve_step *step, double t, double share,
                                  struct rmap_vec3 *r, struct rmap_vec3 *T)
{
    rmap_wide shares = {share, share, share, share};
    rmap_wide of_r, of_T;
    rmap_wide_load(&of_r, step->bend[RMAP_CURVE_POWERS - 1]);
    rmap_wide_load(&of_T, step->turn[RMAP_CURVE_POWERS - 1]);
    RMAP_UNROLL
    for (int k = RMAP_CURVE_POWERS - 2; k >= 0; k--) {
        rmap_wide_horner(&shares, step->bend[k], &of_r);
        rmap_wide_horner(&shares, step->turn[k], &of_T);
    }
    *r = rmap_axpy(t * t, rmap_wide_vec3(&of_r), rmap_axpy(t, step->from.T, step->from.r));
    *T = rmap_axpy(t, rmap_wide_vec3(&of_T), step->from.T);
}

/* An embedded pair of Runge-Kutta-Nystroem formulae; its last stage is the next step's first. */
struct rmap_curve_pair {
    int stages;
    int evaluations; /* of a step */
    int inner;       /* first of four stages in a row that spread over the step */
    double exponent; /* the error of a step goes with this power of h */
    double node[RMAP_CURVE_STAGES];
    double coupling[RMAP_CURVE_STAGES][RMAP_CURVE_STAGES - 1]; /* the last row: the weights of r */
    double weight_T[RMAP_CURVE_STAGES];
    double defect_r[RMAP_CURVE_STAGES]; /* less the embedded formula, two orders lower */
    double defect_T[RMAP_CURVE_STAGES];
    /* h times the sums of D with these are two orders lower than with defect_T, and two more
     * (rougher; all 0: not used). What the defect is to the one, and the one to the other, tells
     * how fast orders fall off: by smoothness times the greater of these the defect is scaled. */
    double rough[RMAP_CURVE_STAGES];
    double rougher[RMAP_CURVE_STAGES];
    double smoothness;
    /* bend[k] of the dense output: the sum of D with these */
    double dense[RMAP_CURVE_POWERS][RMAP_CURVE_STAGES];
    /* The same with one stage more, at theta 1/2 of the interpolant, whose T is an order better. */
    bool has_finer;
    double finer[RMAP_CURVE_POWERS + 1][RMAP_CURVE_STAGES + 1];
};

extern const struct rmap_curve_pair rmap_curve_pair_6, rmap_curve_pair_8;

/* The field at *state's r: sets n and D = n grad n, counts the evaluation. */
bool rmap_curve_evaluate(struct rmap_curve *curve, struct rmap_curve_state *state);

/* One step of h (in t) from step->from, which must be whole: `to`, h and the stages. False, with
 * *step in part, where a stage meets a place without a value. */
bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h);
bool rmap_curve_sharma(struct rmap_curve *curve, struct rmap_curve_step *step, double h);

/* In closed form, finished too: the curve must be `closed`. False where the end has no value; then
 * of *step only r and T of its end are changed. */
bool rmap_curve_closed(struct rmap_curve *curve, struct rmap_curve_step *step, double h);

/* Finds out whether the curve has a closed form. Sets closed, bend and closed_h. */
void rmap_curve_find_closed(struct rmap_curve *curve);

/* Sets the step's share and angle; returns its greatest error's share of what the medium allows: 1
 * is just allowed. */
double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step);

/* Its square, for rough curves: what the next step waits for takes one division and no root. */
double rmap_curve_nystrom_error_square(const struct rmap_curve *curve,
                                       struct rmap_curve_step *step);

/* Error of T inside the step, as a share of what is allowed. */
double rmap_curve_nystrom_between(const struct rmap_curve *curve,
                                  const struct rmap_curve_step *step);

/* Sets step->bend[k], and turn[k] from it. */
static inline void rmap_curve_set_bend(struct rmap_curve_step *step, int k, const rmap_wide *bend)
{
    rmap_wide turn = *bend * (double)(k + 2);
    rmap_wide_store(bend, step->bend[k]);
    rmap_wide_store(&turn, step->turn[k]);
}

/* Sets the whole step's lengths; its dense output stands. */
void rmap_curve_measure(struct rmap_curve_step *step);

/* The rest of the step: what dense output needs, and the lengths. */
void rmap_curve_nystrom_finish(struct rmap_curve_step *step);
void rmap_curve_hermite_finish(struct rmap_curve_step *step);

/* T at theta, better than dense output, of a pair that has_finer: one evaluation. False where the
 * field has no value. */
bool rmap_curve_nystrom_finer(struct rmap_curve *curve, const struct rmap_curve_step *step,
                              double theta, struct rmap_vec3 *T);

#endif
