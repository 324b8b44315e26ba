/* SPDX-License-Identifier: MIT
 *
 * Rays, their segments and weights, all together or told apart (stats_groups.h): a kind of fold
 * (fold.h).
 */
#ifndef RMAP_GROUP_COUNT_H
#define RMAP_GROUP_COUNT_H

#include "analysis/query/fold.h"
#include "analysis/query/query.h"
#include "analysis/stats/stats_groups.h"

/* By detector a ray is in the group of each that registered it. */
struct rmap_group_counting {
    const struct rmap_scene *scene; /* with receivers */
    enum rmap_stats_by by;
    const struct rmap_quantities *quantities; /* of rays, made ready for `by`; NULL: together */
    size_t n_group;
};
struct rmap_group_counting rmap_group_counting(const struct rmap_scene *scene,
                                               enum rmap_stats_by by,
                                               const struct rmap_quantities *quantities);

rmap_column_set rmap_group_count_columns(const struct rmap_group_counting *counting);

/* Context: struct rmap_group_counting. The state is a struct rmap_group_counts. */
extern const struct rmap_fold_kind rmap_group_count_kind;

struct rmap_group_counts {
    const struct rmap_group_counting *of;
    size_t n_value;
    double *value; /* of all groups; rmap_group_counts_read */
    struct rmap_stats_marks marks;
    size_t *counted; /* [n_group] 1 + the row of the ray that was counted there last */
};

/* Adds rays, segments and weights of a group to a count. */
void rmap_group_counts_read(const struct rmap_group_counts *counts, size_t group,
                            struct rmap_count *count);

#endif
