/* SPDX-License-Identifier: MIT
 *
 * Readings of a portion become clusters: their classes, their weights, where each begins.
 */
#include "analysis/stats/stats_block.h"

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"

static void set_groups(struct rmap_stats_setup *setup, size_t n_group)
{
    setup->n_group = n_group;
    setup->n_class = n_group * setup->n_source;
}

void rmap_stats_setup_init(struct rmap_stats_setup *setup, const struct rmap_quantities *quantities,
                           enum rmap_stats_by by, size_t budget_nbytes)
{
    *setup = (struct rmap_stats_setup){
        .quantities = quantities,
        .by = by,
        .n_source = by == RMAP_STATS_BY_SOURCE ? 1 : quantities->scene->n_source,
        .budget_nbytes = budget_nbytes};
    set_groups(setup, rmap_stats_group_count(by, quantities));
}

void rmap_stats_setup_criteria(struct rmap_stats_setup *setup,
                               const struct rmap_stats_criteria *criteria)
{
    setup->criteria = criteria;
    set_groups(setup, criteria->n * setup->n_group);
}

void rmap_stats_setup_paths(struct rmap_stats_setup *setup, const struct rmap_stats_paths *paths)
{
    setup->paths = paths;
    set_groups(setup, paths->n + 1);
}

const char *rmap_stats_setup_name(const struct rmap_stats_setup *setup, size_t group)
{
    return setup->by == RMAP_STATS_BY_CRITERION ? rmap_stats_criterion_name(setup->criteria, group)
           : setup->paths                       ? rmap_stats_path_name(setup->paths, group)
                          : rmap_stats_group_name(setup->by, setup->quantities,
                                                  rmap_stats_setup_own(setup, group));
}

const char *rmap_stats_setup_criterion(const struct rmap_stats_setup *setup, size_t group)
{
    return setup->criteria && setup->by != RMAP_STATS_BY_CRITERION
               ? rmap_stats_criterion_name(setup->criteria,
                                           group / (setup->n_group / setup->criteria->n))
               : NULL;
}

void rmap_stats_reader_fini(struct rmap_stats_reader *reader)
{
    rmap_readings_fini(&reader->readings);
    rmap_stats_marks_fini(&reader->marks);
    rmap_stats_held_fini(&reader->held);
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        rmap_free(reader->value[i]);
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
static void sort_by_class(struct rmap_stats_reader *reader, double *const *value, size_t n_quantity,
                          size_t first, size_t end)
{
    for (size_t k = first + 1; k < end; k++)
        for (size_t j = k; j > first && reader->tag[j - 1] > reader->tag[j]; j--) {
            uint32_t tag = reader->tag[j];
            reader->tag[j] = reader->tag[j - 1];
            reader->tag[j - 1] = tag;
            swap(&reader->weight[j], &reader->weight[j - 1]);
            for (size_t i = 0; i < n_quantity; i++)
                swap(&value[i][j], &value[i][j - 1]);
        }
}

/* Whether groups are of registrations, not of rays. */
static bool are_of_registrations(const struct rmap_stats_setup *setup)
{
    return setup->paths ? rmap_stats_paths_of_registrations(setup->paths)
                        : rmap_stats_group_of_registration(setup->by, setup->quantities);
}

/* Tells readings apart by their rays, or (its) registrations; by criteria alone it does not. */
static bool is_marked(enum rmap_stats_by by)
{
    return by != RMAP_STATS_TOGETHER && by != RMAP_STATS_BY_CRITERION;
}

/* Class of a reading of a ray from the source. group: that of each row; NULL: one. */
static uint32_t class_of(const struct rmap_stats_setup *setup, const uint32_t *group, bool its,
                         const struct rmap_readings *readings, size_t source, size_t k)
{
    const size_t own = group ? group[its ? readings->place[k] : readings->ray[k]] : 0;
    return (uint32_t)(own * setup->n_source + (setup->n_source > 1 ? source : 0));
}

/* Of the readings [first, end) of one ray, whose classes are known: where clusters begin. */
static inline void begin_clusters(struct rmap_stats_reader *reader,
                                  const struct rmap_stats_setup *setup, bool its,
                                  double *const *value, size_t first, size_t end)
{
    if (its)
        sort_by_class(reader, value, setup->quantities->n, first, end);
    uint32_t before = UINT32_MAX;
    for (size_t k = first; k < end; k++) {
        const uint32_t own = reader->tag[k];
        if (own != before)
            reader->tag[k] |= RMAP_STATS_FIRST;
        before = own;
    }
}

static double weigh_one(const struct rmap_readings *readings, const double *weight_of_ray, size_t k)
{
    return (weight_of_ray ? weight_of_ray[readings->ray[k]] : 1.0) * readings->share[k];
}

/* Weights of the readings. Returns whether all are 1. */
static bool weigh(struct rmap_stats_reader *reader, const double *weight_of_ray)
{
    const struct rmap_readings *readings = &reader->readings;
    bool all_one = true;
    for (size_t k = 0; k < readings->n; k++) {
        const double weight = weigh_one(readings, weight_of_ray, k);
        reader->weight[k] = weight;
        all_one = all_one && weight == 1.0;
    }
    return all_one;
}

/* Behind the readings of the ray that reading `first` is of. */
static size_t ray_end(const struct rmap_readings *readings, size_t first)
{
    size_t end = first + 1;
    while (end < readings->n && readings->ray[end] == readings->ray[first])
        end++;
    return end;
}

/* Readings once for each criterion that picks them, ray by ray: a cluster for each. */
static enum rmap_status repeat(struct rmap_stats_reader *reader,
                               const struct rmap_stats_setup *setup,
                               const struct rmap_matched *rays, bool its, bool are_one,
                               struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_readings *readings = &reader->readings;
    const double *weight_of_ray = are_one ? NULL : rays->portion->ray.weight;
    const size_t n_quantity = setup->quantities->n;
    const size_t n_class = setup->n_class / setup->criteria->n;
    const uint32_t *group = is_marked(setup->by) ? reader->marks.group : NULL;
    size_t n = 0, to = 0;
    bool all_one = true;
    RMAP_TRY(rmap_stats_criteria_hold(setup->criteria, rays->portion, readings,
                                      setup->quantities->of_registrations, &reader->held, &n, err));
    RMAP_TRY(RMAP_RESERVE(reader->tag, reader->tag_cap, n + 1, err));
    RMAP_TRY(RMAP_RESERVE(reader->weight, reader->weight_cap, n + 1, err));
    for (size_t i = 0; i < n_quantity; i++)
        RMAP_TRY(RMAP_RESERVE(reader->value[i], reader->value_cap[i], n + 1, err));
    for (size_t first = 0, end = 0; first < readings->n; first = end) {
        end = ray_end(readings, first);
        const size_t source = (size_t)rays->portion->ray.source[readings->ray[first]];
        for (size_t g = 0; g < setup->criteria->n; g++) {
            const size_t from = to;
            for (size_t r = first; r < end; r++) {
                if (!(reader->held.held[r] >> g & 1))
                    continue;
                for (size_t i = 0; i < n_quantity; i++)
                    reader->value[i][to] = readings->value[i][r];
                reader->weight[to] = weigh_one(readings, weight_of_ray, r);
                all_one = all_one && reader->weight[to] == 1.0;
                reader->tag[to++] =
                    (uint32_t)(g * n_class) + class_of(setup, group, its, readings, source, r);
            }
            begin_clusters(reader, setup, its, reader->value, from, to);
        }
    }
    *block = (struct rmap_stats_block){.n = n,
                                       .value = {reader->value[0], reader->value[1]},
                                       .tag = reader->tag,
                                       .weight = all_one ? NULL : reader->weight};
out:
    return st;
}

enum rmap_status rmap_stats_reader_read(struct rmap_stats_reader *reader,
                                        const struct rmap_stats_setup *setup,
                                        const struct rmap_matched *rays,
                                        struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_readings *readings = &reader->readings;
    const bool its = are_of_registrations(setup);
    bool are_one = false;
    RMAP_TRY(rmap_fold_weights(rays, &are_one, err));
    RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_source), err));
    RMAP_TRY(rmap_quantities_read(setup->quantities, rays, readings, err));
    if (!are_one)
        RMAP_TRY(rmap_fold_fetch(rays, setup->quantities->deferred, err));
    if (setup->paths)
        RMAP_TRY(rmap_stats_paths_mark(setup->paths, rays, &reader->marks, err));
    else if (is_marked(setup->by))
        RMAP_TRY(rmap_stats_group_mark(setup->by, setup->quantities, rays->portion, &reader->marks,
                                       err));
    if (setup->criteria) {
        RMAP_TRY(rmap_fold_fetch(rays, rmap_stats_criteria_columns(setup->criteria), err));
        return repeat(reader, setup, rays, its, are_one, block, err);
    }
    RMAP_TRY(RMAP_RESERVE(reader->tag, reader->tag_cap, readings->n + 1, err));
    RMAP_TRY(RMAP_RESERVE(reader->weight, reader->weight_cap, readings->n + 1, err));
    are_one = weigh(reader, are_one ? NULL : rays->portion->ray.weight);
    const uint32_t *group = is_marked(setup->by) ? reader->marks.group : NULL;
    for (size_t first = 0, end = 0; first < readings->n; first = end) {
        end = ray_end(readings, first);
        const size_t source = (size_t)rays->portion->ray.source[readings->ray[first]];
        for (size_t k = first; k < end; k++)
            reader->tag[k] = class_of(setup, group, its, readings, source, k);
        begin_clusters(reader, setup, its, readings->value, first, end);
    }
    *block = (struct rmap_stats_block){.n = readings->n,
                                       .value = {readings->value[0], readings->value[1]},
                                       .tag = reader->tag,
                                       .weight = are_one ? NULL : reader->weight};
out:
    return st;
}
