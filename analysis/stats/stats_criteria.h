/* SPDX-License-Identifier: MIT
 *
 * Statistics of what several criteria pick: a group each, and what more than one of them picks is
 * in several.
 */
#ifndef RMAP_STATS_CRITERIA_H
#define RMAP_STATS_CRITERIA_H

#include "analysis/query/quantity.h"

enum { RMAP_STATS_CRITERIA_MAX = 64 };

/* All borrowed. */
struct rmap_stats_criteria {
    const struct rmap_criterion *const *of; /* [n], at most RMAP_STATS_CRITERIA_MAX */
    const struct rmap_which *const *which;  /* [n] registrations that each has count; NULL: those
                                               that the fold has */
    size_t n;
    const double *flux_per_weight; /* as rmap_map_flux_per_weight */
};

/* "ghost" of @ghost, else the criterion. */
const char *rmap_stats_criterion_name(const struct rmap_stats_criteria *criteria, size_t k);

/* Columns that telling them apart reads. */
rmap_column_set rmap_stats_criteria_columns(const struct rmap_stats_criteria *criteria);

/* Memory for a portion; zeroed at first. */
struct rmap_stats_held {
    uint64_t *held; /* [readings] bit k: criterion k picks it */
    uint8_t *match, *chosen;
    size_t held_cap, match_cap, chosen_cap;
};
void rmap_stats_held_fini(struct rmap_stats_held *held);

/* Which criteria pick the readings. their_rows: they are of registrations. *n_ret: bits that are
 * set. The portion has the columns. */
enum rmap_status rmap_stats_criteria_hold(const struct rmap_stats_criteria *criteria,
                                          const struct rmap_portion *portion,
                                          const struct rmap_readings *readings, bool their_rows,
                                          struct rmap_stats_held *held, size_t *n_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
