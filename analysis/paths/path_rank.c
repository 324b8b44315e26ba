/* SPDX-License-Identifier: MIT
 *
 * The first of many classes are kept in a heap, whose root is the last of them.
 */
#include "analysis/paths/path_rank.h"

#include <stdlib.h>

#include "base/alloc.h"

static int compare_ranked(const void *a_, const void *b_)
{
    const struct rmap_path_ranked *a = a_, *b = b_;
    if (a->value != b->value)
        return a->value > b->value ? -1 : 1;
    if (a->flux != b->flux)
        return a->flux > b->flux ? -1 : 1;
    if (a->first_ray != b->first_ray)
        return a->first_ray < b->first_ray ? -1 : 1;
    if (a->key.high != b->key.high)
        return a->key.high < b->key.high ? -1 : 1;
    return (a->key.low > b->key.low) - (a->key.low < b->key.low);
}

static struct rmap_path_ranked ranked_of(const struct rmap_path_counts *counts, size_t class,
                                         enum rmap_path_sort sort)
{
    const struct rmap_key_sum *sum = &counts->classes.entry[class];
    const double *unit = rmap_map_flux_per_weight(counts->context->map);
    const double rays = (double)sum->number[RMAP_PATH_CLASS_RAYS];
    const double flux = unit[rmap_path_source_of(sum->key)] * sum->weight;
    return (struct rmap_path_ranked){
        .class = class,
        .key = sum->key,
        .first_ray = sum->number[RMAP_PATH_CLASS_FIRST_RAY],
        .value = sort == RMAP_PATH_BY_FLUX   ? flux
                 : sort == RMAP_PATH_BY_RAYS ? rays
                                             : (double)sum->number[RMAP_PATH_CLASS_SEGMENTS] / rays,
        .flux = flux};
}

/* Moves the entry at `at` down to its place. */
static void sift(struct rmap_path_ranked *heap, size_t n, size_t at)
{
    for (size_t child = 2 * at + 1; child < n; child = 2 * at + 1) {
        if (child + 1 < n && compare_ranked(&heap[child + 1], &heap[child]) > 0)
            child++;
        if (compare_ranked(&heap[at], &heap[child]) > 0)
            return;
        const struct rmap_path_ranked entry = heap[at];
        heap[at] = heap[child];
        heap[child] = entry;
        at = child;
    }
}

enum rmap_status rmap_path_rank(const struct rmap_path_counts *counts, enum rmap_path_sort sort,
                                size_t n_row, struct rmap_path_ranked **ranked_ret,
                                struct rmap_error *err)
{
    struct rmap_path_ranked *ranked = rmap_alloc(n_row + 1, sizeof *ranked);
    if (!ranked)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_row);
    for (size_t i = 0; i < n_row; i++)
        ranked[i] = ranked_of(counts, i, sort);
    for (size_t k = n_row / 2; k-- > 0;)
        sift(ranked, n_row, k);
    for (size_t i = n_row; n_row > 0 && i < counts->classes.n; i++) {
        const struct rmap_path_ranked entry = ranked_of(counts, i, sort);
        if (compare_ranked(&entry, &ranked[0]) >= 0)
            continue;
        ranked[0] = entry;
        sift(ranked, n_row, 0);
    }
    qsort(ranked, n_row, sizeof *ranked, compare_ranked);
    *ranked_ret = ranked;
    return RMAP_OK;
}
