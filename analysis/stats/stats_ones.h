/* SPDX-License-Identifier: MIT
 *
 * Clusters of one reading of weight 1 each, which most readings are: sums take them many at once.
 */
#ifndef RMAP_STATS_ONES_H
#define RMAP_STATS_ONES_H

#include "analysis/stats/stats_sums.h"

/* So many are taken at once. */
enum { RMAP_STATS_ONES_MOST = 1024 };

/* Readings [first, first + n) of a block, all of one class; n <= RMAP_STATS_ONES_MOST. */
struct rmap_stats_ones {
    size_t class, first, n;
    bool are_last;                           /* of the class in the portion */
    const double *next[RMAP_QUANTITIES_MAX]; /* that will be asked for next; NULL: not known */
};

/* Those of a block with tags from `first` on, before `last`; none where that cluster is another
 * one. */
struct rmap_stats_ones rmap_stats_ones_at(const struct rmap_stats_block *block, size_t first,
                                          size_t last);

/* The sums have room for them. */
void rmap_stats_sums_add_ones(struct rmap_stats_sums *sums, const struct rmap_stats_block *block,
                              const struct rmap_stats_ones *ones);

#endif
