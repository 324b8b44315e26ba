/* SPDX-License-Identifier: MIT
 *
 * The classes of paths with most flux, for statistics of each.
 */
#ifndef RMAP_STATS_PATHS_RUN_H
#define RMAP_STATS_PATHS_RUN_H

#include "analysis/stats/stats_paths.h"
#include "mpi/scan/path_run.h"

/* Borrowed. */
struct rmap_stats_paths_question {
    const struct rmap_quantities *quantities; /* those of registrations on one detector: of their
                                                 paths until then; the others of whole paths */
    const struct rmap_overlay *overlay;       /* receivers, or NULL */
    const struct rmap_criterion *criterion;   /* NULL: all rays */
    const struct rmap_which *which;           /* NULL: all registrations count */
    enum rmap_path_level level;
    uint64_t top;
};

/* Collective; alike on every rank. rmap_stats_paths_fini whatever happened. */
enum rmap_status rmap_stats_paths_run(const struct rmap_context *context,
                                      const struct rmap_stats_paths_question *question,
                                      struct rmap_stats_paths *paths,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
