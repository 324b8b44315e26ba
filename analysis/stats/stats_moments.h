/* SPDX-License-Identifier: MIT
 *
 * Sums of the powers of readings, per cluster: with q_j = sum over a cluster's readings of
 * weight u^j, j = 0 to 4, the totals of q_j and of all products q_j q_k. u is the value about a
 * centre, in units that keep it in [-1, 1].
 *
 * What one portion of the map adds is summed in the portion's own order, rounded; sums of portions
 * are exact. So the same portions give the same bits, whoever added them and in what order.
 */
#ifndef RMAP_STATS_MOMENTS_H
#define RMAP_STATS_MOMENTS_H

#include "base/exact_sum.h"

enum { RMAP_MOMENTS = 5, RMAP_MOMENT_PRODUCTS = 15 };

/* All zero is empty. */
struct rmap_stats_moments {
    struct rmap_exact_sum total[RMAP_MOMENTS], product[RMAP_MOMENT_PRODUCTS];
    /* Of the portion in hand. */
    size_t n_cluster;
    double its_total[RMAP_MOMENTS], its_product[RMAP_MOMENT_PRODUCTS];
};

/* Ends a portion. */
void rmap_stats_moments_flush(struct rmap_stats_moments *moments);

/* A cluster's sums q. */
void rmap_stats_moments_add(struct rmap_stats_moments *moments, const double q[RMAP_MOMENTS]);

/* Of whole portions. */
void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from);

/* Totals, and the full matrix of products; rounded once each. */
void rmap_stats_moments_value(const struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS]);

#endif
