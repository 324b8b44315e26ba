/* SPDX-License-Identifier: MIT
 *
 * The counts of a query, as text and as JSON.
 */
#ifndef RMAP_QUERY_COUNT_OUT_H
#define RMAP_QUERY_COUNT_OUT_H

#include <jansson.h>

#include "analysis/query/query.h"
#include "io/map/map_cut.h"
#include "mpi/scan/groups.h"
#include "mpi/scan/registered.h"

/* Rank 0. One object, or an array of them, in order, of several criteria or where `listed`; else a
 * table. The table alone does not depend on how the work was shared out: bytes and seconds are
 * talk. nbytes_read UINT64_MAX: not counted, null. registered, groups: [n_criterion]. part: NULL,
 * or what of the map was asked. */
enum rmap_status rmap_query_count_print(const struct rmap_context *context,
                                        const struct rmap_map *map,
                                        struct rmap_criterion *const *criterion,
                                        const struct rmap_count *count,
                                        const struct rmap_registered_list *registered,
                                        const struct rmap_ray_groups *groups, size_t n_criterion,
                                        bool listed, const struct rmap_map_part *part,
                                        double seconds, struct rmap_error *err) RMAP_MUST_USE;

/* One of those objects; NULL: memory is short. The caller's. */
json_t *rmap_query_count_json(const struct rmap_map *map, const struct rmap_criterion *criterion,
                              const struct rmap_count *count,
                              const struct rmap_registered_list *registered, double seconds);

#endif
