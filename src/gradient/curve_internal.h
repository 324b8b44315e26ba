/* SPDX-License-Identifier: MIT
 *
 * What the curve's schemes share: one step each from the curve's state, and its dense output.
 */
#ifndef RMAP_CURVE_INTERNAL_H
#define RMAP_CURVE_INTERNAL_H

#include "gradient/curve.h"

/* The field at *state's r: sets n and D = n grad n, counts the evaluation. */
bool rmap_curve_evaluate(struct rmap_curve *curve, struct rmap_curve_state *state);

/* One step of h (in t) from step->from, which must be whole; sets the rest of *step. False, with
 * *step in part, where a stage meets a place without a value. */
bool rmap_curve_nystrom(struct rmap_curve *curve, struct rmap_curve_step *step, double h);
bool rmap_curve_sharma(struct rmap_curve *curve, struct rmap_curve_step *step, double h);

/* The largest error of the step against what the medium allows: 1 is just allowed. The step's error
 * estimates are of order RMAP_CURVE_ESTIMATE in h. */
#define RMAP_CURVE_ESTIMATE 5
double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step);

/* Dense output of a Nystroem step at theta; r, T, optical and length may be NULL. */
void rmap_curve_nystrom_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                           struct rmap_vec3 *T);
void rmap_curve_nystrom_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                                double *length);

/* Hermite interpolation of (r, T, D) at both ends, and of n^2 and n with their derivatives. */
void rmap_curve_hermite_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                           struct rmap_vec3 *T);
void rmap_curve_hermite_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                                double *length);

#endif
