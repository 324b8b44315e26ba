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
};

/* Fine bin of a value of a quantity. */
static inline size_t rmap_stats_fine(const struct rmap_stats_plan *plan, size_t quantity,
                                     double value)
{
    const double at = (value - plan->fine_low[quantity]) * plan->fine_per[quantity];
    const size_t k = at > 0.0 ? (size_t)at : 0;
    return k < plan->n_fine ? k : plan->n_fine - 1;
}

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
    struct rmap_stats_cell *cell;       /* [n_class][n_cell + BEYOND] */
    double *fine;                       /* [n_class][n quantities][n_fine] weights */
    struct rmap_stats_place *place;     /* of a cluster in hand */
    size_t place_cap;
};

/* Context: the plan. State: struct rmap_stats_sums. */
extern const struct rmap_fold_kind rmap_stats_sums_kind;

/* Adds a portion. */
enum rmap_status rmap_stats_sums_add(struct rmap_stats_sums *sums,
                                     const struct rmap_stats_block *block,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Bytes that a state takes. */
double rmap_stats_sums_nbytes(const struct rmap_stats_setup *setup, double n_cell, double n_fine);

#endif
