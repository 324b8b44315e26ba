/* SPDX-License-Identifier: MIT
 *
 * The statistics of a whole map, on all ranks and threads.
 */
#ifndef RMAP_STATS_RUN_H
#define RMAP_STATS_RUN_H

#include "analysis/stats/stats.h"
#include "mpi/command/command.h"

struct rmap_stats_request {
    const struct rmap_stats_setup *setup;   /* borrowed */
    const struct rmap_criterion *criterion; /* NULL: all rays; borrowed */
    const struct rmap_which *which;         /* NULL: all registrations count */
    struct rmap_stats_axis axis[RMAP_QUANTITIES_MAX];
    const double *p; /* [n_quantile] of the quantiles; borrowed */
    size_t n_quantile;
};

/* Rank 0's result and what it borrows from; on the other ranks empty. */
struct rmap_stats_answer {
    struct rmap_stats *stats; /* NULL on the other ranks */
    struct rmap_stats_plan plan;
};
void rmap_stats_answer_fini(struct rmap_stats_answer *answer);

/* Collective. The map is read once, or twice when the values do not fit into the setup's memory.
 * RMAP_USAGE for bins that would take too much. */
enum rmap_status rmap_stats_run(const struct rmap_context *context,
                                const struct rmap_stats_request *request,
                                struct rmap_stats_answer *answer,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
