/* SPDX-License-Identifier: MIT
 *
 * Which rays are still to be traced: sets of ray ids, and the blocks that a trace hands out.
 *
 * Ray ids are 0 ... 2^64 - 2 (2^64 - 1 stands for "none"), so the end of a range fits in 64 bits.
 */
#ifndef RMAP_RAY_PLAN_H
#define RMAP_RAY_PLAN_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#define RMAP_RAY_END UINT64_MAX /* one above the largest ray id */

struct rmap_ray_range {
    uint64_t first, end; /* [first, end) */
};

/* Zeroed: empty. Ranges are ascending and not empty, and neighbours do not touch. */
struct rmap_ray_set {
    struct rmap_ray_range *range;
    size_t n, cap;
};

void rmap_ray_set_fini(struct rmap_ray_set *set);

/* The union of ranges in any order; those with end <= first are empty. */
enum rmap_status rmap_ray_set_make(const struct rmap_ray_range *range, size_t n,
                                   struct rmap_ray_set *set, struct rmap_error *err) RMAP_MUST_USE;

/* Ids of `from` that are not in `other`, into an empty set. */
enum rmap_status rmap_ray_set_minus(const struct rmap_ray_set *from,
                                    const struct rmap_ray_set *other, struct rmap_ray_set *rest,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Ids of `more` join the set, which stays what it was when that fails. */
enum rmap_status rmap_ray_set_join(struct rmap_ray_set *set, const struct rmap_ray_set *more,
                                   struct rmap_error *err) RMAP_MUST_USE;

uint64_t rmap_ray_set_count(const struct rmap_ray_set *set);

/* A set cut at the multiples of RMAP_BLOCK_RAYS: blocks 0 ... n_block - 1, ascending. */
struct rmap_ray_plan {
    const struct rmap_ray_set *set; /* borrowed */
    uint64_t *first_block;          /* [set->n], number of each range's first block */
    uint64_t n_block, n_ray;
};

enum rmap_status rmap_ray_plan_init(struct rmap_ray_plan *plan, const struct rmap_ray_set *set,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_ray_plan_fini(struct rmap_ray_plan *plan);

/* block < n_block. */
struct rmap_ray_range rmap_ray_plan_block(const struct rmap_ray_plan *plan, uint64_t block);

#endif
