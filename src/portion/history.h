/* SPDX-License-Identifier: MIT
 *
 * Keeps the whole history of one ray in double precision, for reports and tests.
 */
#ifndef RMAP_HISTORY_H
#define RMAP_HISTORY_H

#include <stddef.h>

#include "portion/recorder.h"

struct rmap_history {
    struct rmap_recorder base; /* hand &history.base to the tracer */
    int n_channel;
    enum rmap_status status; /* RMAP_SYSTEM once memory ran short: the history is incomplete */

    /* Colours point into `colour` and are valid once the ray has ended. */
    struct rmap_emission emission;
    struct rmap_step *step; /* [n_step] */
    size_t n_step, step_cap;
    struct rmap_registration *registration; /* [n_registration], in order of happening */
    size_t n_registration, registration_cap;
    struct rmap_curve_point *curve; /* [n_curve], of all curved segments, along the light */
    size_t n_curve, curve_cap;
    struct rmap_ending ending;

    double *colour; /* [1 + n_step][n_channel]: of the emission, then of each step */
    size_t colour_cap;
};

/* Empty; may be used for many rays, each of which replaces the one before. */
void rmap_history_init(struct rmap_history *history, int n_channel);
void rmap_history_fini(struct rmap_history *history);

#endif
