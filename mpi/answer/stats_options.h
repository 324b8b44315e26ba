/* SPDX-License-Identifier: MIT
 *
 * What `raymap stats` is asked for.
 */
#ifndef RMAP_STATS_OPTIONS_H
#define RMAP_STATS_OPTIONS_H

#include "analysis/stats/stats.h"
#include "mpi/command/arguments.h"

struct rmap_stats_options {
    char **of, **where, **unit, **bins, **range, **output; /* owned */
    size_t n_of, n_where, n_unit, n_bins, n_range, n_output;
    const char *detector; /* NULL: not given */
    bool logarithmic;
    enum rmap_stats_by by;
    uint64_t top;     /* classes of paths */
    double *quantile; /* [n_quantile] shares, ascending; owned */
    size_t n_quantile;
    size_t memory_nbytes;
};

/* A word of --by; NULL: TOGETHER. RMAP_USAGE, with the words before `end`. */
enum rmap_status rmap_stats_by_read(const char *word, enum rmap_stats_by end,
                                    enum rmap_stats_by *by, struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE. rmap_stats_options_fini whatever happened. */
enum rmap_status rmap_stats_options_read(const struct rmap_arguments *given,
                                         const char *const *suffixes,
                                         struct rmap_stats_options *options,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_options_fini(struct rmap_stats_options *options);

/* --bins and --range in the quantities' units. RMAP_USAGE. axis: [RMAP_QUANTITIES_MAX], zeroed;
 * rmap_stats_axes_fini whatever happened. */
enum rmap_status rmap_stats_options_axes(const struct rmap_stats_options *options,
                                         const struct rmap_quantities *quantities,
                                         struct rmap_stats_axis *axis,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_axes_fini(struct rmap_stats_axis *axis);

#endif
