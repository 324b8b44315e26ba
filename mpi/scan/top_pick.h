/* SPDX-License-Identifier: MIT
 *
 * The rays that match and have the greatest values of a quantity.
 */
#ifndef RMAP_TOP_PICK_H
#define RMAP_TOP_PICK_H

#include "analysis/query/quantity.h"
#include "analysis/query/sample_fold.h"
#include "mpi/command/command.h"

/* All borrowed. */
struct rmap_top_question {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;     /* NULL: no receivers */
    const struct rmap_criterion *criterion; /* NULL: all rays */
    const struct rmap_which *which;         /* registrations that count; NULL: all */
    const struct rmap_quantities *of; /* one; of several readings of a ray its greatest counts */
    uint64_t most;                    /* rays, >= 1 */
};

/* Collective. *ray_ret: [*n_ret], the greatest first, of equal ones the smaller id; alike on every
 * rank, for any number of ranks and threads; rmap_free. Rays of which no value is defined are not
 * among them. */
enum rmap_status rmap_top_pick(const struct rmap_context *context,
                               const struct rmap_top_question *question,
                               struct rmap_sample_ray **ray_ret, size_t *n_ret,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
