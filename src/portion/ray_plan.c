/* SPDX-License-Identifier: MIT
 *
 * Which rays are still to be traced: sets of ray ids, and the blocks that a trace hands out.
 */
#include "portion/ray_plan.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "portion/portion.h"

void rmap_ray_set_fini(struct rmap_ray_set *set)
{
    rmap_free(set->range);
    *set = (struct rmap_ray_set){0};
}

/* The range must not begin before the set's last one. */
static enum rmap_status put_last(struct rmap_ray_set *set, struct rmap_ray_range range,
                                 struct rmap_error *err)
{
    struct rmap_ray_range *last = set->n ? &set->range[set->n - 1] : NULL;
    if (range.end <= range.first)
        return RMAP_OK;
    if (last && range.first <= last->end) {
        if (range.end > last->end)
            last->end = range.end;
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(set->range, set->cap, set->n + 1, err);
    if (st == RMAP_OK)
        set->range[set->n++] = range;
    return st;
}

static int by_first(const void *a, const void *b)
{
    const struct rmap_ray_range *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

enum rmap_status rmap_ray_set_make(const struct rmap_ray_range *range, size_t n,
                                   struct rmap_ray_set *set, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_range *sorted = rmap_alloc(n ? n : 1, sizeof *sorted);
    *set = (struct rmap_ray_set){0};
    if (!sorted)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of rays");
    if (n > 0) {
        memcpy(sorted, range, n * sizeof *sorted);
        qsort(sorted, n, sizeof *sorted, by_first);
    }
    for (size_t i = 0; st == RMAP_OK && i < n; i++)
        st = put_last(set, sorted[i], err);
    rmap_free(sorted);
    if (st != RMAP_OK)
        rmap_ray_set_fini(set);
    return st;
}

enum rmap_status rmap_ray_set_minus(const struct rmap_ray_set *from,
                                    const struct rmap_ray_set *other, struct rmap_ray_set *rest,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t k = 0;
    *rest = (struct rmap_ray_set){0};
    for (size_t i = 0; i < from->n; i++) {
        struct rmap_ray_range left = from->range[i];
        while (k < other->n && other->range[k].end <= left.first)
            k++;
        /* The last one that cuts this range may cut the next one too: it stays. */
        for (size_t j = k; j < other->n && other->range[j].first < left.end; j++) {
            RMAP_TRY(
                put_last(rest, (struct rmap_ray_range){left.first, other->range[j].first}, err));
            left.first = other->range[j].end;
            k = j;
        }
        RMAP_TRY(put_last(rest, left, err));
    }
out:
    if (st != RMAP_OK)
        rmap_ray_set_fini(rest);
    return st;
}

enum rmap_status rmap_ray_set_join(struct rmap_ray_set *set, const struct rmap_ray_set *more,
                                   struct rmap_error *err)
{
    struct rmap_ray_set joined;
    const size_t n = set->n + more->n;
    struct rmap_ray_range *range = rmap_alloc(n ? n : 1, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of rays");
    for (size_t i = 0; i < n; i++)
        range[i] = i < set->n ? set->range[i] : more->range[i - set->n];
    enum rmap_status st = rmap_ray_set_make(range, n, &joined, err);
    rmap_free(range);
    if (st != RMAP_OK)
        return st;
    rmap_ray_set_fini(set);
    *set = joined;
    return RMAP_OK;
}

uint64_t rmap_ray_set_count(const struct rmap_ray_set *set)
{
    uint64_t count = 0;
    for (size_t i = 0; i < set->n; i++)
        count += set->range[i].end - set->range[i].first;
    return count;
}

static uint64_t count_blocks(struct rmap_ray_range range)
{
    return (range.end - 1) / RMAP_BLOCK_RAYS - range.first / RMAP_BLOCK_RAYS + 1;
}

enum rmap_status rmap_ray_plan_init(struct rmap_ray_plan *plan, const struct rmap_ray_set *set,
                                    struct rmap_error *err)
{
    *plan = (struct rmap_ray_plan){.set = set, .n_ray = rmap_ray_set_count(set)};
    plan->first_block = rmap_alloc(set->n ? set->n : 1, sizeof *plan->first_block);
    if (!plan->first_block)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of blocks");
    for (size_t i = 0; i < set->n; i++) {
        plan->first_block[i] = plan->n_block;
        plan->n_block += count_blocks(set->range[i]);
    }
    return RMAP_OK;
}

void rmap_ray_plan_fini(struct rmap_ray_plan *plan)
{
    rmap_free(plan->first_block);
    *plan = (struct rmap_ray_plan){0};
}

struct rmap_ray_range rmap_ray_plan_block(const struct rmap_ray_plan *plan, uint64_t block)
{
    size_t low = 0, high = plan->set->n;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (plan->first_block[middle] <= block)
            low = middle;
        else
            high = middle;
    }
    struct rmap_ray_range range = plan->set->range[low];
    uint64_t cell = range.first / RMAP_BLOCK_RAYS + (block - plan->first_block[low]);
    uint64_t first = cell * RMAP_BLOCK_RAYS;
    uint64_t room = range.end - (first > range.first ? first : range.first);
    if (first > range.first)
        range.first = first;
    uint64_t in_cell = RMAP_BLOCK_RAYS - range.first % RMAP_BLOCK_RAYS;
    range.end = range.first + (room < in_cell ? room : in_cell);
    return range;
}
