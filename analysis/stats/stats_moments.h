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

#include <stdbool.h>

#include "base/exact_sum.h"

enum {
    RMAP_MOMENTS = 5,
    RMAP_MOMENT_PRODUCTS = 15,
    RMAP_MOMENT_POWERS = 9,
    RMAP_MOMENT_BATCH = 1024
};

/* All zero is empty. */
struct rmap_stats_moments {
    /* Clusters of one reading of weight 1: products are powers. */
    struct rmap_exact_sum power[RMAP_MOMENT_POWERS];
    /* All others. */
    struct rmap_exact_sum total[RMAP_MOMENTS], product[RMAP_MOMENT_PRODUCTS];
    /* Of the portion in hand. */
    size_t n_waiting, n_cluster;
    double waiting[RMAP_MOMENT_BATCH];
    double its_total[RMAP_MOMENTS], its_product[RMAP_MOMENT_PRODUCTS];
};

/* Ends a portion. */
void rmap_stats_moments_flush(struct rmap_stats_moments *moments);

/* n clusters of one reading of weight 1: u = (value - centre) per_scale. Borrowed. */
struct rmap_moment_ones {
    const double *value; /* [n] */
    size_t n;
    double centre, per_scale;
    bool are_last; /* of the portion: they need not wait for others */
    /* What is done beside, as the processor has time for it: */
    const uint16_t *place; /* [n] NULL: none */
    uint32_t *count;       /* count[place] of each goes up by 1 */
    const double *next;    /* about as many readings that will be asked for next; NULL: none */
};
void rmap_stats_moments_add_ones(struct rmap_stats_moments *moments,
                                 const struct rmap_moment_ones *ones);

/* A cluster's sums q. */
void rmap_stats_moments_add(struct rmap_stats_moments *moments, const double q[RMAP_MOMENTS]);

/* Of whole portions. */
void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from);

/* Totals, and the full matrix of products; rounded once each. */
void rmap_stats_moments_value(const struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS]);

#endif
