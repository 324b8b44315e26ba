/* SPDX-License-Identifier: MIT
 *
 * First look at all readings, as a kind of fold (fold.h): how many, their ranges and sum, and, as
 * long as they fit into the setup's memory, the readings themselves.
 */
#ifndef RMAP_STATS_GATHER_H
#define RMAP_STATS_GATHER_H

#include "analysis/stats/stats_block.h"
#include "base/exact_sum.h"

struct rmap_stats_range {
    double low, high; /* low > high: no reading */
    double least_positive;
    uint64_t n_reading, n_cluster;
    struct rmap_exact_sum sum, squared; /* of values, and of their squares */
};

struct rmap_stats_known {
    uint64_t n_ray;     /* matching rays */
    uint64_t n_reading; /* readings of them that are numbers */
    uint64_t n_undefined;
    uint64_t n_several; /* readings that are not the only one of their cluster */
    uint64_t any_weight;
    uint64_t dropped; /* readings are not in memory */
};

/* Readings of one portion in memory: values of each quantity, then weights unless all are 1, then
 * tags. */
struct rmap_stats_part {
    size_t n;
    bool has_weight;
    double *data;
};

struct rmap_stats_gathered {
    const struct rmap_stats_setup *setup;
    struct rmap_stats_known known;
    struct rmap_stats_range *range; /* [n_group][n quantities] */
    struct rmap_stats_reader reader;
    size_t n, n_part, part_cap; /* n: readings in memory */
    struct rmap_stats_part *part;
};

/* Context: the setup. State: struct rmap_stats_gathered. Merging hands readings over. */
extern const struct rmap_fold_kind rmap_stats_gather_kind;

struct rmap_stats_block rmap_stats_gathered_block(const struct rmap_stats_gathered *gathered,
                                                  size_t part);

#endif
