/* SPDX-License-Identifier: MIT
 *
 * Readings as sums take them: clusters, each being what one ray adds to one group. A group is all
 * readings, or (--by) those of one source or detector; its class says the source, too.
 */
#ifndef RMAP_STATS_BLOCK_H
#define RMAP_STATS_BLOCK_H

#include "analysis/query/quantity.h"
#include "analysis/stats/stats_measure.h"

enum rmap_stats_by { RMAP_STATS_TOGETHER, RMAP_STATS_BY_SOURCE, RMAP_STATS_BY_DETECTOR };

struct rmap_stats_setup {
    const struct rmap_quantities *quantities; /* borrowed */
    enum rmap_stats_by by;
    size_t n_group, n_source;
    size_t n_class;       /* group * n_source + source */
    size_t budget_nbytes; /* for readings in memory */
    bool all_rays;        /* no criterion: portions without readings may be skipped */
    bool logarithmic;     /* least positive readings are of interest */
};

void rmap_stats_setup_init(struct rmap_stats_setup *setup, const struct rmap_quantities *quantities,
                           enum rmap_stats_by by, size_t budget_nbytes);

/* Of readings that are not told apart by detector. */
static inline size_t rmap_stats_class_of(const struct rmap_stats_setup *setup, int32_t source)
{
    return (size_t)source * (setup->by == RMAP_STATS_BY_SOURCE ? setup->n_source + 1 : 1);
}

/* The source of all rays of the portion by its summary, or -1. */
int32_t rmap_stats_told_source(const struct rmap_stats_setup *setup,
                               const struct rmap_portion_info *portion);

/* Readings of a class that stand together. */
struct rmap_stats_run {
    size_t end; /* behind the last of them */
    size_t class;
};

/* Readings of a portion. Borrowed arrays. */
struct rmap_stats_block {
    size_t n;
    const double *value[RMAP_QUANTITIES_MAX];
    /* Either tags, that is the class, and the bit below where a cluster begins; or (NULL) runs:
     * then each reading is a cluster of its own, of weight 1. */
    const uint32_t *tag;
    const double *weight;             /* NULL: all 1 */
    const struct rmap_stats_run *run; /* [n_run] */
    size_t n_run;
    bool is_measured;
    struct rmap_stats_measured measured[RMAP_QUANTITIES_MAX]; /* all values, where it is */
    uint16_t *place[RMAP_QUANTITIES_MAX];    /* [n] memory for fine bins of readings; NULL: none */
    const double *next[RMAP_QUANTITIES_MAX]; /* values of the block after it; NULL: not known */
};
#define RMAP_STATS_FIRST 0x80000000u

static inline uint32_t rmap_stats_class(uint32_t tag)
{
    return tag & ~RMAP_STATS_FIRST;
}

/* Behind the last reading of the cluster that begins at `first`. */
static inline size_t rmap_stats_cluster_end(const struct rmap_stats_block *block, size_t first)
{
    size_t end = first + 1;
    while (block->tag && end < block->n && !(block->tag[end] & RMAP_STATS_FIRST))
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

/* Readings in the order of their classes. */
struct rmap_stats_arranged {
    double *value[RMAP_QUANTITIES_MAX], *weight;
    uint32_t *tag;
    size_t *place; /* [n_class + 1] where the next of each class goes */
    size_t value_cap[RMAP_QUANTITIES_MAX], weight_cap, tag_cap, place_cap;
};

/* More sources than that are not gone through one by one. */
enum { RMAP_STATS_SOURCES_FEW = 8 };

/* Memory of a portion's block. All zero at first. */
struct rmap_stats_reader {
    struct rmap_readings readings;
    uint32_t *tag;
    double *weight;
    size_t tag_cap, weight_cap;
    struct rmap_stats_arranged arranged;
    struct rmap_stats_run *run;
    int32_t *source; /* of readings */
    size_t run_cap, source_cap;
    /* Memory for those of a portion and RMAP_PICK_MORE more; NULL: none. Borrowed, used where the
     * block's values would be copied anyway and its readings are stored columns. */
    double *into[RMAP_QUANTITIES_MAX];
};
void rmap_stats_reader_fini(struct rmap_stats_reader *reader);

/* Clusters stand by class, so that sums have long runs of one; those of a class in the order of the
 * portion's rays. The block is the reader's until the next call. */
enum rmap_status rmap_stats_reader_read(struct rmap_stats_reader *reader,
                                        const struct rmap_stats_setup *setup,
                                        const struct rmap_matched *rays,
                                        struct rmap_stats_block *block,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
