/* SPDX-License-Identifier: MIT
 *
 * Rays, their segments and weights, all together or told apart: a kind of fold (fold.h).
 */
#include "analysis/stats/group_count.h"

#include <string.h>

#include "base/alloc.h"
#include "portion/weight.h"

struct rmap_group_counting rmap_group_counting(const struct rmap_scene *scene,
                                               enum rmap_stats_by by,
                                               const struct rmap_quantities *quantities)
{
    return (struct rmap_group_counting){scene, by, quantities,
                                        rmap_stats_group_count(by, quantities)};
}

rmap_column_set rmap_group_count_columns(const struct rmap_group_counting *counting)
{
    const rmap_column_set always = RMAP_COLUMN_BIT(RMAP_RAY_source) |
                                   RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                                   RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    const rmap_column_set rows = RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    return always | (counting->quantities ? counting->quantities->columns : 0) |
           (counting->by == RMAP_STATS_BY_DETECTOR ? rows : 0);
}

/* Of a group: rays, segments, then of each source the sum of weights, then of their squares. */
static size_t group_values(const struct rmap_group_counting *of)
{
    return 2 + 2 * of->scene->n_source;
}

void rmap_group_counts_read(const struct rmap_group_counts *counts, size_t group,
                            struct rmap_count *count)
{
    const size_t n_source = counts->of->scene->n_source;
    const double *value = counts->value + group * group_values(counts->of);
    count->rays += (uint64_t)value[0];
    count->segments += (uint64_t)value[1];
    for (size_t s = 0; s < n_source; s++) {
        count->source_weight[s] += value[2 + s];
        count->source_weight_squared[s] += value[2 + n_source + s];
    }
}

static void destroy(void *state)
{
    struct rmap_group_counts *self = state;
    if (!self)
        return;
    rmap_stats_marks_fini(&self->marks);
    rmap_free(self->value);
    rmap_free(self->counted);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_group_counting *of = context;
    struct rmap_group_counts *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->of = of;
        self->n_value = of->n_group * group_values(of);
        self->value = rmap_alloc(self->n_value + 1, sizeof *self->value);
        self->counted = rmap_alloc(of->n_group + 1, sizeof *self->counted);
    }
    if (self && self->value && self->counted) {
        *state_ret = self;
        return RMAP_OK;
    }
    destroy(self);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu groups", of->n_group);
}

static void count_ray(struct rmap_group_counts *self, size_t group, const struct rmap_portion *rays,
                      size_t i)
{
    double *value = self->value + group * group_values(self->of);
    const double weight = rays->ray.weight[i];
    const size_t source = (size_t)rays->ray.source[i];
    value[0] += 1.0;
    value[1] += rays->ray.segment_count[i];
    value[2 + source] += weight;
    value[2 + self->of->scene->n_source + source] += rmap_weight_squared(weight);
}

/* Once in the group of each detector that registered it in rows [first, end). */
static void count_registered(struct rmap_group_counts *self, const struct rmap_matched *rays,
                             size_t i, size_t first, size_t end)
{
    const uint8_t *counted = rmap_registrations_counted(rays);
    for (size_t row = first; row < end; row++) {
        const size_t d = (size_t)rays->portion->registration.detector[row];
        if (counted[row] && d < self->of->n_group && self->counted[d] != i + 1) {
            self->counted[d] = i + 1;
            count_ray(self, d, rays->portion, i);
        }
    }
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_group_counts *self = state;
    const struct rmap_group_counting *of = self->of;
    const struct rmap_portion *portion = rays->portion;
    const bool by_detector = of->by == RMAP_STATS_BY_DETECTOR;
    const bool is_marked = of->by != RMAP_STATS_TOGETHER && !by_detector;
    if (is_marked)
        RMAP_TRY(rmap_stats_group_mark(of->by, of->quantities, portion, &self->marks, err));
    memset(self->counted, 0, of->n_group * sizeof *self->counted);
    for (size_t i = 0, row = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t first = row;
        row += by_detector ? portion->ray.registration_count[i] : 0;
        if (rays->match && !rays->match[i])
            continue;
        if (portion->ray.source[i] < 0 || (size_t)portion->ray.source[i] >= of->scene->n_source)
            return rmap_error_set(err, RMAP_FORMAT, "damaged map: a source that it has not");
        if (by_detector)
            count_registered(self, rays, i, first, row);
        else
            count_ray(self, is_marked ? self->marks.group[i] : 0, portion, i);
    }
out:
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_group_counts *self = into;
    const struct rmap_group_counts *other = from;
    (void)err;
    for (size_t i = 0; i < self->n_value; i++)
        self->value[i] += other->value[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_group_counts *self = state;
    block[0] = (struct rmap_fold_block){self->value, self->n_value * sizeof *self->value};
    return 1;
}

const struct rmap_fold_kind rmap_group_count_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};
