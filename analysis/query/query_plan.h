/* SPDX-License-Identifier: MIT
 *
 * What a scan for one criterion would read, found out from summaries, and of compact portions from
 * paths and what stands beside them.
 */
#ifndef RMAP_QUERY_PLAN_H
#define RMAP_QUERY_PLAN_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"

struct rmap_query_plan {
    uint64_t n_skipped;              /* portions that cannot hold a match by their summary */
    rmap_column_set columns;         /* read in some portion */
    uint64_t decoded_nbytes;         /* of these columns in these portions, decoded */
    uint64_t n_compact, n_retraced;  /* portions of compact pieces with columns to read; those some
                                        of whose rays may be traced again */
    uint64_t n_told_ray, n_left_ray; /* by their paths; of these, undecided, */
    uint64_t n_traced_ray;           /* and by what stands beside them, too */
};

/* wanted: columns that are to be read of matching rays; 0: none. RMAP_FORMAT as a scan. */
enum rmap_status rmap_query_plan(const struct rmap_map *map, const struct rmap_criterion *criterion,
                                 rmap_column_set wanted, struct rmap_query_plan *plan,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
