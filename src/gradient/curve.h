/* SPDX-License-Identifier: MIT
 *
 * Light through a gradient medium: the eikonal equation in optical-ray form (Sharma, Kumar, Ghatak
 * 1982, doi:10.1364/AO.21.000984),
 *     d2r/dt2 = D(r) = 1/2 grad n^2,   T = dr/dt = n dr/ds,   dt = ds / n,
 * step by step, with dense output. Where the field says that D is linear in r, the steps' ends are
 * exact. World frame. No surfaces here: the tracer tests the curve
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

struct rmap_curve_pair; /* curve_step.h */

#define RMAP_CURVE_STAGES 9
#define RMAP_CURVE_POWERS 7

/* One step; its curve is r(theta), theta in [0, 1]. */
struct rmap_curve_step {
    struct rmap_curve_state from, to;
    double h;               /* in t */
    double optical, length; /* over the step: integrals of n^2 dt, of n dt; as accurate as r */

    /* Dense output: r = from.r + t from.T + t^2 (sum of bend[k] (t / whole)^k), t = theta h */
    double bend[RMAP_CURVE_POWERS][4];  /* x, y, z: four abreast */
    double turn[RMAP_CURVE_POWERS][4];  /* (k + 2) bend[k]: of T */
    double whole;                       /* h before any cut */
    double share;                       /* of a defect that is the error, and the defect of T as */
    double angle;                       /* seen over the medium's size; rough: their squares */
    double allowed;                     /* error of lengths */
    bool rough;                         /* lengths are estimates */
    bool closed;                        /* in closed form */
    const struct rmap_curve_pair *pair; /* the formula; NULL: Sharma's */
    int n_stage;                        /* of it; Sharma's: 0 */
    double D[RMAP_CURVE_STAGES][4];     /* of its stages */
};

struct rmap_curve {
    const struct rmap_gradient *gradient; /* borrowed */
    int channel;
    struct rmap_curve_state state; /* where the next step begins */
    double next_h;                 /* guess for the next step, of the pair of order 8 */
    double share_6;                /* of it: what the pair of order 6 may step */
    double last_h, last_error; /* of an accepted step that next_h has yet to learn from (0: none),
                                  and the share of its error in what was allowed (rough: its
                                  square) */
    double last_growth;
    const struct rmap_curve_pair *last_pair;
    uint64_t n_evaluation; /* of the field, so far */
    uint64_t n_step;
    bool rough;          /* false at first; true: the lengths of steps to come may be estimates,
                            and are chosen quickly */
    bool closed;         /* the field's rays have a closed form: */
    double bend[3][4];   /* dD/dr, column by column */
    double closed_norm;  /* of it: omega^2 at most */
    double closed_least; /* share of a term that dense output does not miss */
    double closed_h;     /* longest step, by its dense output */
    bool blind;          /* the last step ended where the field has no value */
};

/* Works out first_6 and first_8 of the medium's options, which stand and change no more. */
void rmap_curve_prepare(struct rmap_gradient *gradient);

/* From a point in a unit direction. False where the field has no value. */
bool rmap_curve_begin(struct rmap_curve *curve, const struct rmap_gradient *gradient, int channel,
                      struct rmap_vec3 origin, struct rmap_vec3 direction);

/* The next step: no longer than length_max (geometric, about). The curve's state moves to its end.
 * False where the field has no value within reach of any step (the state stays). */
bool rmap_curve_advance(struct rmap_curve *curve, double length_max, struct rmap_curve_step *step);

/* Dense output, no evaluation: position at theta within the tolerance; T within it at the ends, ten
 * times it (as an angle, of tolerance / size) between them. */
void rmap_curve_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                   struct rmap_vec3 *T);

/* Ends the step at theta, as accurately as a step that had been taken to there: may evaluate.
 * step->to, optical and length are of the shorter step; the curve's state is its end. Of a rough
 * step r and T alone are sure, T's length within what dense output allows. */
bool rmap_curve_cut(struct rmap_curve *curve, struct rmap_curve_step *step, double theta);

/* Integrals from the step's start to theta from the dense output (for detectors on the way). */
void rmap_curve_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                        double *length);

/* The integral of the group index ds from the step's start to theta: of n - wavelength
 * dn/dwavelength at a fixed place, over the curve that the phase index bends. */
double rmap_curve_group(const struct rmap_gradient *gradient, int channel,
                        const struct rmap_curve_step *step, double theta);

/* Most that the chord from theta0 to theta1 leaves the curve; an upper bound to 10 %. */
double rmap_curve_sag(const struct rmap_curve_step *step, double theta0, double theta1);

/* Greatest second derivative d2r/dt2 across the curve on the step: a chord over dt leaves the curve
 * by bend dt^2 / 8 at most. Rougher than the sag, and cheap: it looks at the stages alone. */
double rmap_curve_bend(const struct rmap_curve_step *step);

#endif
