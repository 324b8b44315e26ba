/* SPDX-License-Identifier: MIT
 *
 * The rays that match, told apart (--by): how many are in each group, and their flux.
 */
#ifndef RMAP_GROUPS_H
#define RMAP_GROUPS_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/overlay/overlay.h"
#include "analysis/stats/stats_groups.h"
#include "mpi/command/command.h"

struct rmap_ray_group {
    const char *name; /* borrowed from the scene, or the quantities */
    uint64_t rays, segments;
    double flux, standard_error;
};

struct rmap_ray_groups {
    enum rmap_stats_by by;
    size_t n;
    struct rmap_ray_group *group;       /* those that have rays, in the order of the scene */
    const char *unit;                   /* of flux */
    struct rmap_quantities *quantities; /* that groups were told by */
};

/* Collective; the groups are rank 0's. overlay: receivers, or NULL. rmap_ray_groups_fini whatever
 * happened. */
enum rmap_status rmap_ray_groups_run(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_overlay *overlay,
                                     const struct rmap_criterion *criterion, enum rmap_stats_by by,
                                     struct rmap_ray_groups *groups,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_groups_fini(struct rmap_ray_groups *groups);

/* Adds "by" and "groups" to the answer of a criterion; nothing where nothing is told apart. */
void rmap_ray_groups_add_json(json_t *object, const struct rmap_ray_groups *groups);
enum rmap_status rmap_ray_groups_print(const struct rmap_ray_groups *groups, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
