/* SPDX-License-Identifier: MIT
 *
 * Readings of a portion become clusters: their classes, their weights, where each begins.
 */
#include "analysis/stats/stats_block.h"

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"

void rmap_stats_setup_init(struct rmap_stats_setup *setup, const struct rmap_quantities *quantities,
                           enum rmap_stats_by by, size_t budget_nbytes)
{
    *setup = (struct rmap_stats_setup){.quantities = quantities,
                                       .by = by,
                                       .n_group = rmap_stats_group_count(by, quantities->scene),
                                       .n_source = quantities->scene->n_source,
                                       .budget_nbytes = budget_nbytes};
    setup->n_class = setup->n_group * setup->n_source;
}

void rmap_stats_reader_fini(struct rmap_stats_reader *reader)
{
    rmap_readings_fini(&reader->readings);
    rmap_stats_marks_fini(&reader->marks);
    rmap_free(reader->tag);
    rmap_free(reader->weight);
    *reader = (struct rmap_stats_reader){0};
}

static void swap(double *a, double *b)
{
    double kept = *a;
    *a = *b;
    *b = kept;
}

/* Sorts the readings [first, end) of one ray by class; equal ones keep their order. */
static void sort_by_class(struct rmap_stats_reader *reader, size_t n_quantity, size_t first,
                          size_t end)
{
    struct rmap_readings *readings = &reader->readings;
    for (size_t k = first + 1; k < end; k++)
        for (size_t j = k; j > first && reader->tag[j - 1] > reader->tag[j]; j--) {
            uint32_t tag = reader->tag[j];
            reader->tag[j] = reader->tag[j - 1];
            reader->tag[j - 1] = tag;
            swap(&reader->weight[j], &reader->weight[j - 1]);
            for (size_t i = 0; i < n_quantity; i++)
                swap(&readings->value[i][j], &readings->value[i][j - 1]);
        }
}

/* The readings [first, end) of one ray: their classes, and where clusters begin. */
static void tag_ray(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                    const struct rmap_portion *portion, size_t first, size_t end)
{
    const struct rmap_readings *readings = &reader->readings;
    const size_t source = (size_t)portion->ray.source[readings->ray[first]];
    const bool its = rmap_stats_group_of_registration(setup->by, setup->quantities);
    const uint32_t *group = setup->by == RMAP_STATS_TOGETHER ? NULL : reader->marks.group;
    for (size_t k = first; k < end; k++) {
        const size_t own = group ? group[its ? readings->place[k] : readings->ray[k]] : 0;
        reader->tag[k] = (uint32_t)(own * setup->n_source + source);
    }
    if (its)
        sort_by_class(reader, setup->quantities->n, first, end);
    uint32_t before = UINT32_MAX;
    for (size_t k = first; k < end; k++) {
        const uint32_t own = reader->tag[k];
        if (own != before)
            reader->tag[k] |= RMAP_STATS_FIRST;
        before = own;
    }
}

/* Weights of the readings. Returns whether all are 1. */
static bool weigh(struct rmap_stats_reader *reader, const double *weight_of_ray)
{
    const struct rmap_readings *readings = &reader->readings;
    bool all_one = true;
    for (size_t k = 0; k < readings->n; k++) {
        const double weight =
            (weight_of_ray ? weight_of_ray[readings->ray[k]] : 1.0) * readings->share[k];
        reader->weight[k] = weight;
        all_one = all_one && weight == 1.0;
    }
    return all_one;
}

enum rmap_status rmap_stats_reader_read(struct rmap_stats_reader *reader,
                                        const struct rmap_stats_setup *setup,
                                        const struct rmap_matched *rays,
                                        struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_readings *readings = &reader->readings;
    bool are_one = false;
    RMAP_TRY(rmap_fold_weights(rays, &are_one, err));
    RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_source), err));
    RMAP_TRY(rmap_quantities_read(setup->quantities, rays, readings, err));
    if (!are_one)
        RMAP_TRY(rmap_fold_fetch(rays, setup->quantities->deferred, err));
    RMAP_TRY(RMAP_RESERVE(reader->tag, reader->tag_cap, readings->n + 1, err));
    RMAP_TRY(RMAP_RESERVE(reader->weight, reader->weight_cap, readings->n + 1, err));
    if (setup->by != RMAP_STATS_TOGETHER)
        RMAP_TRY(rmap_stats_group_mark(setup->by, setup->quantities, rays->portion, &reader->marks,
                                       err));
    are_one = weigh(reader, are_one ? NULL : rays->portion->ray.weight);
    for (size_t first = 0, end = 0; first < readings->n; first = end) {
        for (end = first + 1; end < readings->n && readings->ray[end] == readings->ray[first];)
            end++;
        tag_ray(reader, setup, rays->portion, first, end);
    }
    *block = (struct rmap_stats_block){.n = readings->n,
                                       .value = {readings->value[0], readings->value[1]},
                                       .tag = reader->tag,
                                       .weight = are_one ? NULL : reader->weight};
out:
    return st;
}
