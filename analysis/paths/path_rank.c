/* SPDX-License-Identifier: MIT */
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

struct ranking {
    const struct rmap_path_counts *counts;
    enum rmap_path_sort sort;
    size_t n_row;
    struct rmap_path_ranked *ranked; /* [n] a heap once there are n_row */
    size_t n;
    uint64_t fewest; /* rays below which no class has a place: 0 where that is not told yet */
};

static void note_fewest(struct ranking *self)
{
    const struct rmap_map *map = self->counts->context->map;
    const double *unit = rmap_map_flux_per_weight(map);
    double most = self->sort == RMAP_PATH_BY_RAYS ? 1.0 : 0.0;
    if (self->sort == RMAP_PATH_BY_FLUX && !self->counts->tally.classes.is_wide)
        for (size_t s = 0; s < rmap_map_scene(map)->n_source; s++)
            most = unit[s] > most ? unit[s] : most;
    const double rays = most > 0.0 ? self->ranked[0].value / most * (1.0 - 1e-12) : 0.0;
    self->fewest = rays > 0.0 && rays < 0x1p63 ? (uint64_t)rays : 0;
}

/* Takes the class among the first, if it is one of them so far. */
RMAP_COPIED void consider(struct ranking *self, size_t class)
{
    const struct rmap_class_sums *classes = &self->counts->tally.classes;
    const double *unit = rmap_map_flux_per_weight(self->counts->context->map);
    struct rmap_path_ranked *ranked = self->ranked;
    if (classes->entry[class].rays < self->fewest)
        return;
    const double value = value_of(classes, class, self->sort, unit);
    if (self->n == self->n_row && value < ranked[0].value)
        return;
    const struct rmap_path_ranked entry = {class, classes->entry[class].first_ray, value,
                                           flux_of(classes, class, unit)};
    if (self->n < self->n_row) {
        ranked[self->n++] = entry;
        for (size_t k = self->n_row / 2; self->n == self->n_row && k-- > 0;)
            sift(ranked, self->n_row, k);
    } else if (compare_ranked(&entry, &ranked[0]) < 0) {
        ranked[0] = entry;
        sift(ranked, self->n_row, 0);
    }
    if (self->n == self->n_row)
        note_fewest(self);
}

/* Those of many rays. False: others may have a place, too. */
static bool rank_many(struct ranking *self)
{
    const struct rmap_class_many *many = self->counts->tally.classes.many;
    for (size_t k = 0; many && many->n >= self->n_row && k < many->n; k++)
        consider(self, many->class[k]);
    return self->n == self->n_row && self->fewest >= many->least;
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
    if (n_row > 0 && !rank_many(&ranking)) {
        ranking.n = 0;
        ranking.fewest = 0;
        for (size_t i = 0; i < counts->tally.classes.n; i++)
            consider(&ranking, i);
    }
    qsort(ranking.ranked, ranking.n, sizeof *ranking.ranked, compare_ranked);
    *ranked_ret = ranking.ranked;
    return RMAP_OK;
}
