/* SPDX-License-Identifier: MIT
 *
 * One sum over the rays of a map that match: portions are added to states, one per thread, states
 * are merged, and the whole is what a command shows.
 */
#include "analysis/query/fold.h"

#include <string.h>

#include "analysis/query/fold_internal.h"
#include "analysis/query/query_marker.h"
#include "analysis/query/query_sums.h"
#include "base/alloc.h"
#include "base/count.h"
#include "io/map/map_cursor.h"

rmap_column_set rmap_fold_columns(const struct rmap_fold *fold)
{
    return fold->columns | (rmap_which_chooses(fold->which) ? fold->which->columns : 0);
}

/* Whether rays that may arrive at a detector are all that matters, and what is told of these alone.
 */
static bool may_narrow(const struct rmap_fold *fold)
{
    const rmap_column_set columns =
        rmap_fold_columns(fold) | (fold->criterion ? rmap_criterion_columns(fold->criterion) : 0);
    return (fold->only_detector > 0 || fold->registered_alone) &&
           !(columns & ~RMAP_COLUMNS_ARRIVAL);
}

/* What paths tell leaves the receivers out: rays are evaluated by columns. */
static enum rmap_status lay_over(struct rmap_fold_scanner *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = self->fold;
    rmap_column_set columns = rmap_fold_columns(fold);
    if (fold->criterion)
        columns |= rmap_criterion_columns(fold->criterion);
    RMAP_TRY(rmap_overlay_view_create(fold->overlay, &self->view, err));
    st = rmap_cursor_create(fold->map, rmap_overlay_columns(fold->overlay, columns), &self->cursor,
                            err);
out:
    return st;
}

enum rmap_status rmap_fold_scanner_create(const struct rmap_fold *fold,
                                          struct rmap_fold_scanner **scanner_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_fold_scanner *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->fold = fold;
    self->which = rmap_which_chooses(fold->which) ? fold->which : NULL;
    self->crossing.detector = fold->only_detector - 1;
    self->narrows = may_narrow(fold);
    if (fold->overlay) {
        RMAP_TRY(lay_over(self, err));
    } else {
        if (fold->criterion)
            st = rmap_query_marker_create(fold->map, fold->criterion, rmap_fold_columns(fold),
                                          &self->marker, err);
        else
            st = rmap_cursor_create(fold->map, rmap_fold_columns(fold), &self->cursor, err);
        RMAP_TRY(st);
    }
    *scanner_ret = self;
    self = NULL;
out:
    rmap_fold_scanner_destroy(self);
    return st;
}

void rmap_fold_scanner_destroy(struct rmap_fold_scanner *self)
{
    if (!self)
        return;
    rmap_query_marker_destroy(self->marker);
    rmap_cursor_destroy(self->cursor);
    rmap_overlay_view_destroy(self->view);
    rmap_crossing_fini(&self->crossing);
    rmap_free(self->match);
    rmap_free(self->chosen);
    rmap_free(self->open);
    rmap_free(self->unsure);
    rmap_free(self->exact);
    rmap_free(self);
}

/* The rays of an extended portion that match. */
static enum rmap_status evaluator(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = self->fold;
    const size_t n = rays->portion->n_row[RMAP_TABLE_RAY];
    if (!fold->criterion)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->match, self->n_match, n, err));
    RMAP_TRY(rmap_criterion_evaluate(fold->criterion, rays->portion,
                                     rmap_map_flux_per_weight(fold->map), self->match, err));
    rays->match = self->match;
    rays->n_match = rmap_count_ones(self->match, n);
out:
    return st;
}

static enum rmap_status read_extended(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *stored = NULL;
    RMAP_TRY(rmap_cursor_read(self->cursor, rays->index, &stored, err));
    RMAP_TRY(rmap_overlay_view_extend(self->view, stored, rays->space, &rays->portion, err));
    st = evaluator(self, rays, err);
out:
    return st;
}

static enum rmap_status mark(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                             struct rmap_error *err)
{
    uint8_t *match = NULL;
    enum rmap_status st = rmap_query_marker_mark(self->marker, &match, &rays->n_match, err);
    rays->match = match;
    return st;
}

enum rmap_status rmap_fold_read(struct rmap_fold_scanner *self, rmap_column_set columns,
                                const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    return self->marker ? rmap_query_marker_read(self->marker, columns, portion_ret, err)
                        : rmap_cursor_fetch(self->cursor, columns, err);
}

enum rmap_status rmap_fold_enter(struct rmap_fold_scanner *self, struct rmap_cursor **cursor_ret,
                                 struct rmap_error *err)
{
    *cursor_ret = self->cursor;
    return self->marker ? rmap_query_marker_cursor(self->marker, cursor_ret, err) : RMAP_OK;
}

/* Of the rays that match, those that cross the only detector, and may add something, into `match`.
 */
static enum rmap_status keep_fewer(struct rmap_fold_scanner *self, void *state,
                                   struct rmap_cursor *cursor, const struct rmap_portion *portion,
                                   struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(self->fold->map, rays->index);
    const size_t n = (size_t)info->n_row[RMAP_TABLE_RAY];
    const bool narrows = self->fold->kind->narrow != NULL;
    if (self->fold->only_detector == 0 && !narrows)
        return RMAP_OK;
    if (!rays->match)
        memset(self->match, 1, n);
    else
        memcpy(self->match, rays->match, n);
    if (narrows)
        RMAP_TRY(self->fold->kind->narrow(state, rays, self->match, err));
    if (self->fold->only_detector > 0) {
        RMAP_TRY(rmap_fold_read(self, 0, &portion, err)); /* the marker's */
        RMAP_TRY(rmap_crossing_keep(&self->crossing, cursor, portion, (size_t)info->piece,
                                    self->match, err));
    }
    rays->match = self->match;
    rays->n_match = rmap_count_ones(self->match, n);
out:
    return st;
}

/* Rays that must be traced again, where few of them can add anything: the portion becomes those,
 * with all columns that the kind may ask for. NULL: it would not be of use. */
static enum rmap_status select_rays(struct rmap_fold_scanner *self, void *state,
                                    const struct rmap_portion *portion, rmap_column_set columns,
                                    struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set all = (self->bounding ? self->bounding : rmap_fold_columns(self->fold)) |
                                RMAP_COLUMN_BIT(RMAP_RAY_weight);
    const size_t n = (size_t)rmap_map_portion(self->fold->map, rays->index)->n_row[RMAP_TABLE_RAY];
    struct rmap_cursor *cursor = NULL;
    const uint32_t *row = NULL;
    if (!rmap_map_selects(self->fold->map, rays->index, columns))
        goto out;
    RMAP_TRY(RMAP_RESERVE(self->match, self->n_match, n + 1, err));
    RMAP_TRY(rmap_fold_enter(self, &cursor, err));
    RMAP_TRY(keep_fewer(self, state, cursor, portion, rays, err));
    if (!rays->match || rays->n_match == 0)
        goto out;
    RMAP_TRY(rmap_cursor_select(cursor, rays->match, 1, all, &rays->portion, &row, err));
    if (rays->portion) {
        self->row = row;
        const size_t n_selected = rays->portion->n_row[RMAP_TABLE_RAY];
        const bool all_match = n_selected == rays->n_match;
        for (size_t s = 0; !all_match && s < n_selected; s++) /* row[s] >= s */
            self->match[s] = rays->match[row[s]];
        rays->match = all_match ? NULL : self->match;
        rays->scanner = NULL;
    }
out:
    return st;
}

/* Where what the kind reads stands in the portion, and tells something of what choosing
 * registrations reads: those columns alone are read at first. */
static enum rmap_status bound(struct rmap_fold_scanner *self, size_t portion,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor;
    rmap_column_set traced;
    if (!self->which || self->view || !rmap_which_may_be_bound(self->which))
        return RMAP_OK;
    RMAP_TRY(rmap_fold_enter(self, &cursor, err));
    RMAP_TRY(rmap_cursor_traced(cursor, &traced, err));
    const rmap_column_set told = rmap_cursor_tells_of(cursor, self->which->columns & traced);
    if (told && !(self->fold->columns & traced) &&
        rmap_map_selects(self->fold->map, portion,
                         told)) /* else columns are kept, bounds are not */
        self->bounding = (rmap_fold_columns(self->fold) & ~traced) | told;
out:
    return st;
}

/* Takes the rays of a stored portion in hand that may add something, and marks those that match. */
static enum rmap_status enter_stored(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->is_narrow = false;
    if (!self->marker) {
        RMAP_TRY(rmap_cursor_enter(self->cursor, rays->index, &rays->portion, err));
        if (self->narrows)
            RMAP_TRY(rmap_cursor_narrow(self->cursor, &self->is_narrow, err));
        rays->n_match = rays->portion->n_row[RMAP_TABLE_RAY];
        goto out;
    }
    RMAP_TRY(rmap_query_marker_enter(self->marker, rays->index, &rays->n_match, err));
    if (rays->n_match > 0 && self->narrows)
        RMAP_TRY(rmap_query_marker_narrow(self->marker, &self->is_narrow, &rays->n_match, err));
    if (rays->n_match > 0)
        st = mark(self, rays, err);
out:
    return st;
}

static enum rmap_status read_stored(struct rmap_fold_scanner *self, void *state,
                                    struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_column_set columns =
        self->which ? rmap_fold_columns(self->fold) : self->fold->columns & ~self->fold->deferred;
    RMAP_TRY(enter_stored(self, rays, err));
    if (rays->n_match == 0)
        goto out;
    RMAP_TRY(bound(self, rays->index, err));
    columns = self->bounding ? self->bounding : columns;
    const struct rmap_portion *portion = rays->portion;
    rays->portion = NULL;
    if (!self->is_narrow)
        RMAP_TRY(select_rays(self, state, portion, columns, rays, err));
    if (rays->n_match == 0 || rays->portion)
        goto out;
    rays->portion = portion;
    st = rmap_fold_read(self, columns, &rays->portion, err);
out:
    return st;
}

enum rmap_status rmap_fold_fetch(const struct rmap_matched *rays, rmap_column_set columns,
                                 struct rmap_error *err)
{
    const struct rmap_portion *portion;
    if (!rays->scanner || rays->scanner->view)
        return RMAP_OK;
    return rmap_fold_read(rays->scanner, columns, &portion, err);
}

static enum rmap_status tell_weights(const struct rmap_matched *rays, bool *are_one_ret,
                                     struct rmap_error *err)
{
    const struct rmap_fold_scanner *scanner = rays->scanner;
    return scanner->marker ? rmap_query_marker_weigh(scanner->marker, are_one_ret, err)
                           : rmap_cursor_weigh(scanner->cursor, are_one_ret, err);
}

enum rmap_status rmap_fold_weights(const struct rmap_matched *rays, bool *are_one_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool known = false;
    if (!rays->portion->ray.weight)
        RMAP_TRY(tell_weights(rays, &known, err));
    if (!known) {
        RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_weight), err));
        known =
            rmap_weights_are_one(rays->portion->ray.weight, rays->portion->n_row[RMAP_TABLE_RAY]);
    }
    *are_one_ret = known;
out:
    return st;
}

enum rmap_status rmap_fold_path_summary(const struct rmap_matched *rays,
                                        struct rmap_path_summary *paths, struct rmap_error *err)
{
    struct rmap_cursor *cursor;
    enum rmap_status st = RMAP_OK;
    *paths = (struct rmap_path_summary){.paths = NULL};
    if (!rays->scanner || rays->scanner->view || rays->chosen)
        return RMAP_OK;
    RMAP_TRY(rmap_fold_enter(rays->scanner, &cursor, err));
    st = rmap_cursor_path_summary(cursor, false, paths, err);
out:
    return st;
}

enum rmap_status rmap_fold_path_bounds(const struct rmap_matched *rays,
                                       struct rmap_path_summary *paths,
                                       const struct rmap_path_sum **sum_ret,
                                       const struct rmap_path_sum **own_ret, struct rmap_error *err)
{
    struct rmap_cursor *cursor;
    enum rmap_status st = RMAP_OK;
    *sum_ret = *own_ret = NULL;
    RMAP_TRY(rmap_fold_path_summary(rays, paths, err));
    if (!paths->paths)
        goto out;
    RMAP_TRY(rmap_fold_enter(rays->scanner, &cursor, err));
    RMAP_TRY(rmap_cursor_path_sums(cursor, sum_ret, err));
    st = rmap_cursor_own_lengths(cursor, own_ret, err);
out:
    return st;
}

enum rmap_status rmap_fold_own_paths(const struct rmap_matched *rays,
                                     const struct rmap_portion **own_ret, struct rmap_error *err)
{
    struct rmap_cursor *cursor;
    enum rmap_status st = rmap_fold_enter(rays->scanner, &cursor, err);
    return st == RMAP_OK
               ? rmap_cursor_own_paths(cursor, RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_id),
                                       own_ret, err)
               : st;
}

static enum rmap_status add_portion(struct rmap_fold_scanner *self, void *state, size_t index,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = self->fold;
    const struct rmap_portion_info *info = rmap_map_portion(fold->map, index);
    struct rmap_portion_info extended;
    struct rmap_matched rays = {.index = index,
                                .space = (size_t)info->space,
                                .n_match = (size_t)info->n_row[RMAP_TABLE_RAY],
                                .scanner = self};
    if (fold->overlay) {
        rmap_overlay_info(fold->overlay, info, &extended);
        info = &extended;
        if (fold->criterion && !rmap_criterion_may_match(fold->criterion, &info->summary))
            return RMAP_OK;
    }
    if (fold->kind->may_count && !fold->kind->may_count(fold->context, info))
        return RMAP_OK;
    self->bounding = 0;
    self->row = NULL;
    RMAP_TRY(fold->overlay ? read_extended(self, &rays, err)
                           : read_stored(self, state, &rays, err));
    if (rays.n_match > 0 && self->which)
        RMAP_TRY(rmap_fold_choose(self, &rays, err));
    if (rays.n_match > 0)
        st = fold->kind->add(state, &rays, err);
out:
    return st;
}

uint64_t rmap_fold_scanner_nbytes(const struct rmap_fold_scanner *self)
{
    return self->marker ? rmap_query_marker_nbytes(self->marker)
                        : rmap_cursor_nbytes_of_rows(self->cursor);
}

enum rmap_status rmap_fold_scanner_add(struct rmap_fold_scanner *self, void *state, size_t first,
                                       size_t last, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = first; i < last && st == RMAP_OK; i++)
        st = add_portion(self, state, i, err);
    return st;
}
