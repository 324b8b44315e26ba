/* SPDX-License-Identifier: MIT
 *
 * What statistics are told apart by (--by): of rays, or of registrations, the discrete things that
 * they have.
 */
#ifndef RMAP_STATS_GROUPS_H
#define RMAP_STATS_GROUPS_H

#include "analysis/query/quantity.h"

enum rmap_stats_by {
    RMAP_STATS_TOGETHER,
    RMAP_STATS_BY_SOURCE,
    RMAP_STATS_BY_DETECTOR, /* of registrations */
    RMAP_STATS_BY_OBJECT,   /* met last; of registrations, before the segment on which they were */
    RMAP_STATS_BY_ENDED,
    RMAP_STATS_BY_GHOST_ORDER, /* analysis/criterion/path_order.h */
    RMAP_STATS_BY_SCATTER_ORDER,
    RMAP_STATS_BY_EVENT,     /* of the ray (scene/events.h) */
    RMAP_STATS_BY_CRITERION, /* stats_criteria.h tells them apart, */
    RMAP_STATS_BY_PATH,      /* and stats_paths.h these: whose names count */
    RMAP_STATS_BY_PATH_OBJECT,
    RMAP_STATS_BY_PATH_GROUP,
    RMAP_STATS_BY_COUNT
};

/* What --by calls it; NULL: TOGETHER. */
const char *rmap_stats_by_word(enum rmap_stats_by by);

/* How many groups there are, and their names: borrowed of the quantities, which are made ready for
 * them (rmap_stats_group_prepare; of TOGETHER may be NULL), NULL of the one of TOGETHER. Not for
 * CRITERION and PATH, which is true of the functions below, too. */
size_t rmap_stats_group_count(enum rmap_stats_by by, const struct rmap_quantities *quantities);
const char *rmap_stats_group_name(enum rmap_stats_by by, const struct rmap_quantities *quantities,
                                  size_t group);

/* Whether a registration's group may be another than that of the next one of its ray. */
bool rmap_stats_group_of_registration(enum rmap_stats_by by,
                                      const struct rmap_quantities *quantities);

/* Makes the quantities read what groups are told by, too. RMAP_INPUT where the map has no events,
 * or too many. */
enum rmap_status rmap_stats_group_prepare(enum rmap_stats_by by, struct rmap_quantities *quantities,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Memory for a portion's groups; zeroed at first. */
struct rmap_stats_marks {
    uint32_t *group, *other; /* per ray, or per registration where groups are theirs */
    size_t group_cap, other_cap;
};
void rmap_stats_marks_fini(struct rmap_stats_marks *marks);

/* marks->group: of every row of the portion. Not for TOGETHER. */
enum rmap_status rmap_stats_group_mark(enum rmap_stats_by by,
                                       const struct rmap_quantities *quantities,
                                       const struct rmap_portion *portion,
                                       struct rmap_stats_marks *marks,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
