/* SPDX-License-Identifier: MIT
 *
 * Readings as sums take them: clusters, each being what one ray adds to one group. A group is all
 * readings, or (--by) those of one source, detector ...; its class says the source, too.
 */
#ifndef RMAP_STATS_BLOCK_H
#define RMAP_STATS_BLOCK_H

#include "analysis/stats/stats_criteria.h"
#include "analysis/stats/stats_paths.h"

/* For readings in memory, of each thread, where nobody says how much. */
#define RMAP_STATS_BUDGET_NBYTES ((size_t)128 << 20)

struct rmap_stats_setup {
    const struct rmap_quantities *quantities; /* borrowed */
    enum rmap_stats_by by;
    const struct rmap_stats_criteria *criteria; /* borrowed; NULL: not by these */
    const struct rmap_stats_paths *paths;       /* the same */
    size_t n_group;
    size_t n_source;      /* told apart in a group: those of the scene; BY_SOURCE: 1 */
    size_t n_class;       /* group * n_source + source */
    size_t budget_nbytes; /* for readings in memory */
    bool all_rays;        /* no criterion: portions without readings may be skipped */
    bool logarithmic;     /* least positive readings are of interest */
};

void rmap_stats_setup_init(struct rmap_stats_setup *setup, const struct rmap_quantities *quantities,
                           enum rmap_stats_by by, size_t budget_nbytes);

/* Tells readings apart by criteria too, or by classes of paths; both are borrowed. */
void rmap_stats_setup_criteria(struct rmap_stats_setup *setup,
                               const struct rmap_stats_criteria *criteria);
void rmap_stats_setup_paths(struct rmap_stats_setup *setup, const struct rmap_stats_paths *paths);

/* NULL: of the one of TOGETHER. */
const char *rmap_stats_setup_name(const struct rmap_stats_setup *setup, size_t group);
/* Of groups of several criteria, its own; NULL: the name says it, or there is one. */
const char *rmap_stats_setup_criterion(const struct rmap_stats_setup *setup, size_t group);
/* What it is among the groups of its criterion. */
static inline size_t rmap_stats_setup_own(const struct rmap_stats_setup *setup, size_t group)
{
    return setup->criteria ? group % (setup->n_group / setup->criteria->n) : group;
}

/* The scene's source that the s-th of a group is. */
static inline size_t rmap_stats_setup_source(const struct rmap_stats_setup *setup, size_t group,
                                             size_t s)
{
    return setup->by == RMAP_STATS_BY_SOURCE ? rmap_stats_setup_own(setup, group) : s;
}

/* Readings of a portion. Borrowed arrays. */
struct rmap_stats_block {
    size_t n;
    const double *value[RMAP_QUANTITIES_MAX];
    const uint32_t *tag;  /* the class, and the bit below where a cluster begins */
    const double *weight; /* NULL: all 1 */
};
#define RMAP_STATS_FIRST 0x80000000u

static inline size_t rmap_stats_class(const struct rmap_stats_block *block, size_t k)
{
    return block->tag[k] & ~RMAP_STATS_FIRST;
}

/* Behind the last reading of the cluster that begins at `first`. */
static inline size_t rmap_stats_cluster_end(const struct rmap_stats_block *block, size_t first)
{
    size_t end = first + 1;
    while (end < block->n && !(block->tag[end] & RMAP_STATS_FIRST))
        end++;
    return end;
}

/* Bins add up weights, and their squares, as multiples of 2^-24: such sums are exact in double up
 * to 2^29 rays, whatever the order; whole weights stay what they are. */
static inline double rmap_stats_rounded(double weight)
{
    const double shift = 0x1.8p28; /* 1.5 2^(52 - 24) */
    return (weight + shift) - shift;
}

static inline double rmap_stats_weight(const struct rmap_stats_block *block, size_t k)
{
    return block->weight ? rmap_stats_rounded(block->weight[k]) : 1.0;
}

/* Memory of a portion's block. All zero at first. */
struct rmap_stats_reader {
    struct rmap_readings readings;
    struct rmap_stats_marks marks;
    struct rmap_stats_held held;
    uint32_t *tag;
    double *weight, *value[RMAP_QUANTITIES_MAX]; /* of readings; values where they are repeated */
    size_t tag_cap, weight_cap, value_cap[RMAP_QUANTITIES_MAX];
};
void rmap_stats_reader_fini(struct rmap_stats_reader *reader);

/* Clusters in the order of the portion's rays. The block is the reader's until the next call. */
enum rmap_status rmap_stats_reader_read(struct rmap_stats_reader *reader,
                                        const struct rmap_stats_setup *setup,
                                        const struct rmap_matched *rays,
                                        struct rmap_stats_block *block,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
