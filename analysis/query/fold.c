/* SPDX-License-Identifier: MIT
 *
 * One sum over the rays of a map that match: portions are added to states, one per thread, states
 * are merged, and the whole is what a command shows.
 */
#include "analysis/query/fold.h"

#include "analysis/query/query_marker.h"
#include "analysis/query/query_sums.h"
#include "base/alloc.h"
#include "base/count.h"
#include "io/map/map_cursor.h"

struct rmap_fold_scanner {
    const struct rmap_fold *fold;
    struct rmap_query_marker *marker; /* NULL: all rays match, or receivers are laid over the map */
    struct rmap_cursor *cursor;       /* NULL: the marker reads */
    struct rmap_overlay_view *view;   /* NULL: no receivers */
    uint8_t *match;                   /* [n_match] */
    size_t n_match;
    size_t n_alike; /* portions to come that are taken to be like one of which most rays crossed */
    const struct rmap_which *which; /* NULL: all registrations count */
    uint8_t *chosen;                /* [chosen_cap] */
    size_t chosen_cap;
};

/* Columns that the portion needs, whatever else decides which rays match. */
static rmap_column_set columns_of(const struct rmap_fold *fold)
{
    return fold->columns | (rmap_which_chooses(fold->which) ? fold->which->columns : 0);
}

/* What paths tell leaves the receivers out: rays are evaluated by columns. */
static enum rmap_status lay_over(struct rmap_fold_scanner *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = self->fold;
    rmap_column_set columns = columns_of(fold);
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
    if (fold->overlay) {
        RMAP_TRY(lay_over(self, err));
    } else {
        if (fold->criterion)
            st = rmap_query_marker_create(fold->map, fold->criterion, columns_of(fold),
                                          &self->marker, err);
        else
            st = rmap_cursor_create(fold->map, columns_of(fold), &self->cursor, err);
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
    rmap_free(self->match);
    rmap_free(self->chosen);
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

/* Columns of the portion in hand. */
static enum rmap_status read_columns(struct rmap_fold_scanner *self, rmap_column_set columns,
                                     const struct rmap_portion **portion_ret,
                                     struct rmap_error *err)
{
    return self->marker ? rmap_query_marker_read(self->marker, columns, portion_ret, err)
                        : rmap_cursor_fetch(self->cursor, columns, err);
}

/* What one portion costs in vain is lost in so many. */
enum { ALIKE = 16 };

/* Of the rays that match, those that crossed a detector, into `match`. */
static void keep_crossing(struct rmap_fold_scanner *self, const struct rmap_portion *portion,
                          struct rmap_matched *rays)
{
    const size_t n = portion->n_row[RMAP_TABLE_RAY];
    const int32_t detector = self->fold->only_detector - 1;
    size_t row = 0;
    for (size_t i = 0; i < n; i++) {
        uint8_t crosses = 0;
        for (const size_t end = row + portion->ray.registration_count[i]; row < end; row++)
            crosses |= portion->registration.detector[row] == detector;
        self->match[i] = crosses & (rays->match ? rays->match[i] : 1);
    }
    rays->match = self->match;
    rays->n_match = rmap_count_ones(self->match, n);
}

/* Rays that must be traced again, where few of them can add anything: the portion becomes those,
 * with all columns that the kind may ask for. NULL: it would not be of use. */
static enum rmap_status select_rays(struct rmap_fold_scanner *self, rmap_column_set columns,
                                    struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const rmap_column_set all = columns_of(self->fold) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    const size_t n = (size_t)rmap_map_portion(self->fold->map, rays->index)->n_row[RMAP_TABLE_RAY];
    struct rmap_cursor *cursor = self->cursor;
    const uint32_t *row = NULL;
    rays->portion = NULL;
    if (!rmap_map_selects(self->fold->map, rays->index, columns))
        goto out;
    RMAP_TRY(RMAP_RESERVE(self->match, self->n_match, n + 1, err));
    if (self->fold->only_detector > 0 && self->n_alike > 0) {
        self->n_alike--;
    } else if (self->fold->only_detector > 0) {
        RMAP_TRY(read_columns(self,
                              RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                                  RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector),
                              &portion, err));
        keep_crossing(self, portion, rays);
        self->n_alike = rays->n_match > n / 2 ? ALIKE : 0;
    }
    if (!rays->match || rays->n_match == 0)
        goto out;
    if (self->marker)
        RMAP_TRY(rmap_query_marker_cursor(self->marker, &cursor, err));
    RMAP_TRY(rmap_cursor_select(cursor, rays->match, 1, all, &rays->portion, &row, err));
    if (rays->portion) {
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

static enum rmap_status read_stored(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set columns =
        self->which ? columns_of(self->fold) : self->fold->columns & ~self->fold->deferred;
    const struct rmap_portion *portion = NULL;
    if (self->marker) {
        RMAP_TRY(rmap_query_marker_enter(self->marker, rays->index, &rays->n_match, err));
        if (rays->n_match == 0)
            goto out;
        RMAP_TRY(mark(self, rays, err));
    } else {
        RMAP_TRY(rmap_cursor_enter(self->cursor, rays->index, &portion, err));
    }
    rays->portion = portion;
    if (rays->n_match > 0)
        RMAP_TRY(select_rays(self, columns, rays, err));
    if (rays->n_match == 0 || rays->portion)
        goto out;
    rays->portion = portion;
    st = read_columns(self, columns, &rays->portion, err);
out:
    return st;
}

enum rmap_status rmap_fold_fetch(const struct rmap_matched *rays, rmap_column_set columns,
                                 struct rmap_error *err)
{
    const struct rmap_portion *portion;
    if (!rays->scanner || rays->scanner->view)
        return RMAP_OK;
    return read_columns(rays->scanner, columns, &portion, err);
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

/* What reads the portion. */
static enum rmap_status cursor_of(const struct rmap_matched *rays, struct rmap_cursor **cursor_ret,
                                  struct rmap_error *err)
{
    const struct rmap_fold_scanner *scanner = rays->scanner;
    *cursor_ret = scanner->cursor;
    return scanner->marker ? rmap_query_marker_cursor(scanner->marker, cursor_ret, err) : RMAP_OK;
}

enum rmap_status rmap_fold_path_summary(const struct rmap_matched *rays,
                                        struct rmap_path_summary *paths, struct rmap_error *err)
{
    struct rmap_cursor *cursor;
    enum rmap_status st = RMAP_OK;
    *paths = (struct rmap_path_summary){.paths = NULL};
    if (!rays->scanner || rays->scanner->view || rays->chosen)
        return RMAP_OK;
    RMAP_TRY(cursor_of(rays, &cursor, err));
    st = rmap_cursor_path_summary(cursor, false, paths, err);
out:
    return st;
}

enum rmap_status rmap_fold_own_paths(const struct rmap_matched *rays,
                                     const struct rmap_portion **own_ret, struct rmap_error *err)
{
    struct rmap_cursor *cursor;
    enum rmap_status st = cursor_of(rays, &cursor, err);
    return st == RMAP_OK
               ? rmap_cursor_own_paths(cursor, RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_id),
                                       own_ret, err)
               : st;
}

/* The registrations of the portion that count. */
static enum rmap_status choose(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->chosen, self->chosen_cap,
                          rays->portion->n_row[RMAP_TABLE_REGISTRATION] + 1, err));
    RMAP_TRY(rmap_which_mark(self->which, rays->portion, self->chosen, err));
    rays->chosen = self->chosen;
out:
    return st;
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
    RMAP_TRY(fold->overlay ? read_extended(self, &rays, err) : read_stored(self, &rays, err));
    if (rays.n_match > 0 && self->which)
        RMAP_TRY(choose(self, &rays, err));
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
