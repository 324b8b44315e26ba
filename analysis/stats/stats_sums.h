/* SPDX-License-Identifier: MIT
 *
 * Second look at all readings, once their ranges are known: moments, the histogram asked for, and
 * a fine one for quantiles. Over readings in memory, or as a kind of fold over the map.
 */
#ifndef RMAP_STATS_SUMS_H
#define RMAP_STATS_SUMS_H

#include "analysis/stats/stats_block.h"
#include "analysis/stats/stats_moments.h"
#include "analysis/table/bins.h"

struct rmap_stats_plan {
    const struct rmap_stats_setup *setup;
    double centre[RMAP_QUANTITIES_MAX], scale[RMAP_QUANTITIES_MAX];
    double per_scale[RMAP_QUANTITIES_MAX]; /* u = (value - centre) per_scale */
    struct rmap_bins bins[RMAP_QUANTITIES_MAX];
    size_t n_cell; /* of the histogram: x fastest */
    size_t n_fine; /* bins of [fine_low, fine_low + n_fine / fine_per) */
    double fine_low[RMAP_QUANTITIES_MAX], fine_per[RMAP_QUANTITIES_MAX];
    /* Of one quantity in memory, cells may be made of fine bins, from one of them on. 0: not. */
    size_t n_fine_per_cell, n_fine_below;
};

/* Of a cell and class: clusters with readings there, sum of their weights and of its square. */
struct rmap_stats_cell {
    double rays, weight, squared;
};

/* Cells behind the histogram's own: below its range and above it (of two quantities: outside). */
enum { RMAP_STATS_BELOW, RMAP_STATS_ABOVE, RMAP_STATS_BEYOND };

struct rmap_stats_sums {
    const struct rmap_stats_plan *plan;
    struct rmap_stats_reader reader;
    struct rmap_stats_moments *moments; /* [n_class][n quantities] */
    struct rmap_stats_cell *cell;       /* [n_class][n_cell + BEYOND], of other clusters than: */
    double *single;                     /* same layout: clusters of one reading of weight 1 */
    double *fine;                       /* [n_class][n quantities][n_fine] weights of the others */
    uint32_t *fine_single;              /* same layout: clusters of one reading of weight 1 */
    uint64_t n_single;                  /* that may be in one bin of them */
    struct rmap_stats_place *place;     /* of a cluster in hand */
    size_t place_cap;
};

/* Context: the plan. State: struct rmap_stats_sums. */
extern const struct rmap_fold_kind rmap_stats_sums_kind;

/* Adds a portion, or a run of one. */
enum rmap_status rmap_stats_sums_add(struct rmap_stats_sums *sums,
                                     const struct rmap_stats_block *block,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Once all is added and merged: cells that are made of fine bins. */
void rmap_stats_sums_finish(struct rmap_stats_sums *sums);

/* Bytes that a state takes. */
double rmap_stats_sums_nbytes(const struct rmap_stats_setup *setup, double n_cell, double n_fine);

#endif
