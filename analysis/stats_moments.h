/* SPDX-License-Identifier: MIT
 *
 * Sums of the powers of readings, per cluster and exactly: with q_j = sum over a cluster's
 * readings of weight u^j, j = 0 to 4, the totals of q_j and of all products q_j q_k. u is the
 * value about a centre, in units that keep it in [-1, 1].
 */
#ifndef RMAP_STATS_MOMENTS_H
#define RMAP_STATS_MOMENTS_H

#include "base/exact_sum.h"

enum {
    RMAP_MOMENTS = 5,
    RMAP_MOMENT_PRODUCTS = 15,
    RMAP_MOMENT_POWERS = 9,
    RMAP_MOMENT_BATCH = 1024
};

/* All zero is empty. */
struct rmap_stats_moments {
    /* Clusters of one reading of weight 1: products are powers, which go in batches. */
    struct rmap_exact_sum power[RMAP_MOMENT_POWERS];
    /* All others. */
    struct rmap_exact_sum total[RMAP_MOMENTS], product[RMAP_MOMENT_PRODUCTS];
    size_t n_waiting;
    double waiting[RMAP_MOMENT_BATCH];
};

void rmap_stats_moments_flush(struct rmap_stats_moments *moments);

/* A cluster of one reading of weight 1. */
static inline void rmap_stats_moments_add_one(struct rmap_stats_moments *moments, double u)
{
    moments->waiting[moments->n_waiting++] = u;
    if (moments->n_waiting == RMAP_MOMENT_BATCH)
        rmap_stats_moments_flush(moments);
}

/* A cluster's sums q. */
void rmap_stats_moments_add(struct rmap_stats_moments *moments, const double q[RMAP_MOMENTS]);

void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from);

/* Totals, and the full matrix of products; rounded once each. */
void rmap_stats_moments_value(struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS]);

#endif
