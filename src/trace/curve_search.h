/* SPDX-License-Identifier: MIT
 *
 * The first surface that a curve meets, one run of steps after the other.
 *
 * Chords of the curve are tested against the scene. Where one meets a surface, the place where the
 * curve crosses that surface's tangent plane says where a chord short enough to be the curve
 * itself, within a tenth of the tolerance, must decide. Where none does, the control polygon on the
 * curve's outer side is tested too: a surface that crosses neither, nor ends between them, does not
 * cross the curve; else the piece is halved. So only bodies and gaps smaller than the sag can be
 * passed over, and that is bounded by the medium's `sag`.
 */
#ifndef RMAP_CURVE_SEARCH_H
#define RMAP_CURVE_SEARCH_H

#include "accel/accel.h"
#include "gradient/curve.h"

#define RMAP_CURVE_RUN_MAX 16

/* Steps that are searched together. Time is that of the curve, from the run's start. */
struct rmap_curve_run {
    int n;
    struct rmap_curve_step step[RMAP_CURVE_RUN_MAX];
    double time[RMAP_CURVE_RUN_MAX + 1]; /* at the steps' ends; time[0] is 0 */
    double bend;                         /* greatest of the steps' */
    double pull;                         /* greatest square of D at the steps' ends */
    double length;
};

/* The step of a run at a time, and how far into it. */
int rmap_curve_run_find(const struct rmap_curve_run *run, double time, double *theta);

struct rmap_curve_search {
    const struct rmap_accel *accel;           /* borrowed */
    const struct rmap_curve_options *options; /* borrowed */
    bool rough;                               /* for a picture */
    double decides;                           /* sag of a chord that may end the segment */
    struct rmap_curve_run run;
    double ahead;            /* distance to a surface straight ahead of the run's start */
    struct rmap_ray ray;     /* of the chord in hand; contact: as long as it starts the segment */
    struct rmap_vec3 normal; /* of the surface that the segment starts on */
};

/* A segment that starts as `ray` does; normal: of the surface it starts on, if its contact has one.
 * rough: only a picture is made of it, which does not show the last tenth of the tolerance. */
void rmap_curve_search_begin(struct rmap_curve_search *search, const struct rmap_accel *accel,
                             const struct rmap_curve_options *options, bool rough,
                             const struct rmap_ray *ray, struct rmap_vec3 normal);

/* A run with no steps yet, from a point of the curve in the direction of T. True with *hit when a
 * surface touches its very start. */
bool rmap_curve_search_start(struct rmap_curve_search *search, const struct rmap_curve_state *state,
                             struct rmap_hit *hit);

/* Takes run.step[run.n], which the caller has filled. True when the run should be searched. */
bool rmap_curve_search_add(struct rmap_curve_search *search);

/* The first surface on the run up to `*time`. hit: position on the surface; t: 0 for a surface that
 * touches the segment's start, else > 0. */
bool rmap_curve_search_run(struct rmap_curve_search *search, double *time, struct rmap_hit *hit);

#endif
