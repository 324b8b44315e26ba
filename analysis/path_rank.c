/* SPDX-License-Identifier: MIT */
#include "analysis/path_rank.h"

#include <stdlib.h>

#include "base/alloc.h"

static int compare_ranked(const void *a_, const void *b_)
{
    const struct rmap_path_ranked *a = a_, *b = b_;
    if (a->value != b->value)
        return a->value > b->value ? -1 : 1;
    if (a->flux != b->flux)
        return a->flux > b->flux ? -1 : 1;
    return (a->first_ray > b->first_ray) - (a->first_ray < b->first_ray);
}

static inline double flux_of(const struct rmap_class_sums *classes, size_t i, const double *unit)
{
    const struct rmap_class_entry *its = &classes->entry[i];
    const double weight = classes->is_wide ? classes->more[i].weight : (double)its->rays;
    return unit[rmap_path_source_of(its->key)] * weight;
}

static inline double value_of(const struct rmap_class_sums *classes, size_t i,
                              enum rmap_path_sort sort, const double *unit)
{
    if (sort == RMAP_PATH_BY_FLUX)
        return flux_of(classes, i, unit);
    const double rays = (double)classes->entry[i].rays;
    if (sort == RMAP_PATH_BY_RAYS)
        return rays;
    return (double)rmap_class_sums_at(classes, i).more.segments / rays;
}

/* Moves the entry at `at` down to its place in a heap, whose root comes last of all. */
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

/* Rays below which no class has a place among those in the full heap: 0 where that is not told
 * beforehand. */
static uint64_t fewest_rays(const struct rmap_path_counts *counts, enum rmap_path_sort sort,
                            const struct rmap_path_ranked *root)
{
    const struct rmap_map *map = counts->context->map;
    const double *unit = rmap_map_flux_per_weight(map);
    double most = sort == RMAP_PATH_BY_RAYS ? 1.0 : 0.0;
    if (sort == RMAP_PATH_BY_FLUX && !counts->tally.classes.is_wide)
        for (size_t s = 0; s < rmap_map_scene(map)->n_source; s++)
            most = unit[s] > most ? unit[s] : most;
    const double rays = most > 0.0 ? root->value / most * (1.0 - 1e-12) : 0.0;
    return rays > 0.0 && rays < 0x1p63 ? (uint64_t)rays : 0;
}

enum rmap_status rmap_path_rank(const struct rmap_path_counts *counts, enum rmap_path_sort sort,
                                size_t n_row, struct rmap_path_ranked **ranked_ret,
                                struct rmap_error *err)
{
    const struct rmap_class_sums *classes = &counts->tally.classes;
    const double *unit = rmap_map_flux_per_weight(counts->context->map);
    struct rmap_path_ranked *ranked = rmap_alloc(n_row + 1, sizeof *ranked);
    uint64_t fewest = 0;
    size_t n = 0;
    if (!ranked)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_row);
    for (size_t i = 0; n_row > 0 && i < classes->n; i++) {
        if (classes->entry[i].rays < fewest)
            continue;
        const double value = value_of(classes, i, sort, unit);
        if (n == n_row && value < ranked[0].value)
            continue;
        const struct rmap_path_ranked entry = {i, classes->entry[i].first_ray, value,
                                               flux_of(classes, i, unit)};
        if (n < n_row) {
            ranked[n++] = entry;
            for (size_t k = n_row / 2; n == n_row && k-- > 0;)
                sift(ranked, n_row, k);
        } else if (compare_ranked(&entry, &ranked[0]) < 0) {
            ranked[0] = entry;
            sift(ranked, n_row, 0);
        }
        if (n == n_row)
            fewest = fewest_rays(counts, sort, &ranked[0]);
    }
    qsort(ranked, n, sizeof *ranked, compare_ranked);
    *ranked_ret = ranked;
    return RMAP_OK;
}
