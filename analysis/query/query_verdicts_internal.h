/* SPDX-License-Identifier: MIT
 *
 * What query_verdicts.c and query_verdicts_read.c share.
 */
#ifndef RMAP_QUERY_VERDICTS_INTERNAL_H
#define RMAP_QUERY_VERDICTS_INTERNAL_H

#include "analysis/query/query_known.h"
#include "analysis/query/query_sums.h"
#include "analysis/query/query_undecided.h"
#include "analysis/query/query_verdicts.h"

struct rmap_query_verdicts {
    const struct rmap_map *map;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    struct rmap_shared_tests shared;
    struct rmap_judge judge;
    struct rmap_cursor *cursor; /* columns of the criteria and the sums */
    struct rmap_query_history *history;
    struct rmap_query_known *known_paths; /* or NULL */
    struct rmap_undecided undecided;

    size_t index;                         /* portion in hand */
    const struct rmap_history_view *view; /* NULL: its columns are to be read */
    size_t n_ray;
    bool is_entered;                    /* by the cursor */
    const struct rmap_portion *portion; /* the cursor's */
    bool is_by_paths;                   /* what was judged last, without decoding the rays */
    bool is_looked_at;                  /* for what the sums need to know: */
    struct rmap_sums_facts facts;
    rmap_column_set known;      /* columns unfolded from its history */
    struct rmap_portion joined; /* these, and those of the cursor */
    bool is_judged_whole;       /* what the judge judged last: all its rays */
    bool *is_open;              /* [n_criterion] its history leaves rays undecided */
    uint8_t *verdict;           /* [n_criterion][n_ray] of its history */
    uint8_t *own, *marked;      /* [n_ray] of undecided rays; of all rays */
    uint32_t *path_rays;        /* [n_path] that match */
    size_t verdict_cap, path_cap;
};

/* The portion's columns in hand. */
enum rmap_status rmap_query_verdicts_enter_columns(struct rmap_query_verdicts *verdicts,
                                                   struct rmap_error *err) RMAP_MUST_USE;

/* For evidence: context is the verdicts, which have entered columns. */
enum rmap_status rmap_query_verdicts_fetch(void *context, rmap_column_set columns,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif
