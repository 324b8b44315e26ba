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

struct ranking {
    const struct rmap_path_counts *counts;
    enum rmap_path_sort sort;
    struct rmap_path_ranked *ranked; /* [n_row] a heap when there are n_row */
    size_t n_row, n;
    uint64_t fewest;
};

/* Takes the class in, if it has a place so far. */
static inline void offer(struct ranking *self, size_t i)
{
    const struct rmap_class_sums *classes = &self->counts->tally.classes;
    const double *unit = rmap_map_flux_per_weight(self->counts->context->map);
    struct rmap_path_ranked *ranked = self->ranked;
    if (classes->entry[i].rays < self->fewest)
        return;
    const double value = value_of(classes, i, self->sort, unit);
    if (self->n == self->n_row && value < ranked[0].value)
        return;
    const struct rmap_path_ranked entry = {i, classes->entry[i].first_ray, value,
                                           flux_of(classes, i, unit)};
    if (self->n < self->n_row) {
        ranked[self->n++] = entry;
        for (size_t k = self->n_row / 2; self->n == self->n_row && k-- > 0;)
            sift(ranked, self->n_row, k);
    } else if (compare_ranked(&entry, &ranked[0]) < 0) {
        ranked[0] = entry;
        sift(ranked, self->n_row, 0);
    }
    if (self->n == self->n_row)
        self->fewest = fewest_rays(self->counts, self->sort, &ranked[0]);
}

/* Which of classes [first, first + 64) have several rays. */
static inline uint64_t again_at(const struct rmap_class_sums *classes, size_t first)
{
    return first < classes->n ? classes->again[first / 64] : 0;
}

/* Classes of several rays come first, their entries asked for some words ahead: often those of one,
 * which are most, have no place then. */
static void offer_all(struct ranking *ranking)
{
    enum { AHEAD = 4 * 64 };
    const struct rmap_class_sums *classes = &ranking->counts->tally.classes;
    for (size_t first = 0; first < classes->n; first += 64) {
        uint64_t next = again_at(classes, first + AHEAD), left = again_at(classes, first);
        for (; next != 0; next &= next - 1)
            __builtin_prefetch(&classes->entry[first + AHEAD + (size_t)__builtin_ctzll(next)]);
        for (; left != 0; left &= left - 1)
            offer(ranking, first + (size_t)__builtin_ctzll(left));
    }
    for (size_t i = 0; ranking->fewest < 2 && i < classes->n; i++)
        if (!rmap_class_sums_is_again(classes, i))
            offer(ranking, i);
}

enum rmap_status rmap_path_rank(const struct rmap_path_counts *counts, enum rmap_path_sort sort,
                                size_t n_row, struct rmap_path_ranked **ranked_ret,
                                struct rmap_error *err)
{
    struct ranking ranking = {.counts = counts,
                              .sort = sort,
                              .n_row = n_row,
                              .ranked = rmap_alloc(n_row + 1, sizeof *ranking.ranked)};
    if (!ranking.ranked)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_row);
    if (n_row > 0)
        offer_all(&ranking);
    qsort(ranking.ranked, ranking.n, sizeof *ranking.ranked, compare_ranked);
    *ranked_ret = ranking.ranked;
    return RMAP_OK;
}
