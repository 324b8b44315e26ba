/* SPDX-License-Identifier: MIT
 *
 * What an answer is by blocks of rays, so that differences between variants with the same rays are
 * told with errors of their own: what chance does to both of them alike drops out of the difference
 * of each block (common random numbers; P. Glasserman and D. D. Yao 1992,
 * doi:10.1287/mnsc.38.6.884; batches: L. Schruben 1983, doi:10.1287/opre.31.6.1090).
 */
#ifndef RMAP_SWEEP_PARTS_H
#define RMAP_SWEEP_PARTS_H

#include "analysis/detector/detector_bins.h"
#include "analysis/query/quantity.h"
#include "analysis/query/query.h"
#include "analysis/sweep/sweep.h"

#define RMAP_SWEEP_PARTS 32 /* blocks of rays with ids that follow each other */

/* All borrowed. */
struct rmap_sweep_parts_ask {
    const struct rmap_sweep_answer *answer;
    const struct rmap_map *map;
    uint64_t n_ray;
    int32_t detector;                         /* of DETECTOR */
    const struct rmap_detector_bins *bins;    /* whose region counts, of its spot; or NULL */
    const struct rmap_quantities *quantities; /* of STATISTIC */
    const struct rmap_fold_kind *with; /* another sum of the same rays, in the same pass, or NULL */
    const void *with_context;
    double about[2]; /* near the answer's mean or centre: sums about it lose no digits */
};

/* Whether the answer has parts: extremes and radii have none. */
bool rmap_sweep_has_parts(const struct rmap_sweep_answer *answer);

/* As a fold (fold.h): context a struct rmap_sweep_parts_ask. */
extern const struct rmap_fold_kind rmap_sweep_parts_kind;
rmap_column_set rmap_sweep_parts_columns(const struct rmap_sweep_parts_ask *ask);

/* Of a state: that of `with`, and how many rays there are, of FLUX and RAYS. */
void *rmap_sweep_parts_with(void *state);
const struct rmap_count *rmap_sweep_parts_count(const void *state);

/* value: the answer of all rays. Fluxes and counts: parts of a sum, which is the answer; others:
 * what the answer of each block alone is. */
void rmap_sweep_parts_values(const void *state, double value, double part[RMAP_SWEEP_PARTS]);

/* Standard error of the difference of two answers of the same rays, NaN where it is not defined. */
double rmap_sweep_parts_error(const struct rmap_sweep_answer *answer,
                              const double a[RMAP_SWEEP_PARTS], const double b[RMAP_SWEEP_PARTS]);

#endif
