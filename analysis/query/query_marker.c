/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion match one criterion, by paths and columns as a scan finds them.
 */
#include "analysis/query/query_marker.h"

#include "analysis/criterion/criterion_tree.h"
#include "analysis/query/query_outcomes.h"
#include "base/alloc.h"
#include "base/count.h"

struct rmap_query_marker {
    const struct rmap_map *map;
    const struct rmap_criterion *criterion;
    struct rmap_query_outcomes *outcomes;
    size_t n_ray; /* of the portion in hand */
    uint8_t *match;
    size_t cap;
};

enum rmap_status rmap_query_marker_create(const struct rmap_map *map,
                                          const struct rmap_criterion *criterion,
                                          rmap_column_set more,
                                          struct rmap_query_marker **marker_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_marker *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->map = map;
    self->criterion = criterion;
    RMAP_TRY(rmap_query_outcomes_create(map, &self->criterion, criterion != NULL, more,
                                        &self->outcomes, err));
    *marker_ret = self;
    self = NULL;
out:
    rmap_query_marker_destroy(self);
    return st;
}

void rmap_query_marker_destroy(struct rmap_query_marker *self)
{
    if (!self)
        return;
    rmap_query_outcomes_destroy(self->outcomes);
    rmap_free(self->match);
    rmap_free(self);
}

enum rmap_status rmap_query_marker_enter(struct rmap_query_marker *self, size_t portion,
                                         size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    *n_ret = self->n_ray = 0;
    if (self->criterion && rmap_criterion_skips(self->criterion, info))
        return RMAP_OK;
    RMAP_TRY(rmap_query_outcomes_enter(self->outcomes, portion, err));
    *n_ret = self->n_ray = (size_t)info->n_row[RMAP_TABLE_RAY];
out:
    return st;
}

enum rmap_status rmap_query_marker_narrow(struct rmap_query_marker *self, bool *is_narrow_ret,
                                          size_t *n_ret, struct rmap_error *err)
{
    const enum rmap_status st =
        rmap_query_outcomes_narrow(self->outcomes, is_narrow_ret, &self->n_ray, err);
    *n_ret = self->n_ray;
    return st;
}

enum rmap_status rmap_query_marker_mark(struct rmap_query_marker *self, uint8_t **match_ret,
                                        size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = self->n_ray; /* entering vouched for it */
    *match_ret = NULL;
    *n_ret = n_ray;
    if (!self->criterion || n_ray == 0)
        return RMAP_OK;
    st = RMAP_RESERVE(self->match, self->cap, n_ray, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_query_outcomes_mark(self->outcomes, 0, self->match, err));
    *match_ret = self->match;
    *n_ret = rmap_count_ones(self->match, n_ray);
out:
    return st;
}

enum rmap_status rmap_query_marker_read(struct rmap_query_marker *self, rmap_column_set columns,
                                        const struct rmap_portion **portion_ret,
                                        struct rmap_error *err)
{
    return rmap_query_outcomes_read(self->outcomes, columns, portion_ret, err);
}

enum rmap_status rmap_query_marker_weigh(struct rmap_query_marker *self, bool *are_one_ret,
                                         struct rmap_error *err)
{
    return rmap_query_outcomes_weigh(self->outcomes, are_one_ret, err);
}

enum rmap_status rmap_query_marker_cursor(struct rmap_query_marker *self,
                                          struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    return rmap_query_outcomes_cursor(self->outcomes, cursor_ret, err);
}

uint64_t rmap_query_marker_nbytes(const struct rmap_query_marker *self)
{
    return rmap_query_outcomes_nbytes(self->outcomes);
}
