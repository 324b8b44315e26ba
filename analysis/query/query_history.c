/* SPDX-License-Identifier: MIT
 *
 * A piece's dictionary is evaluated once, as if its paths were rays; a portion in the form PATHS
 * then looks its outcomes up.
 */
#include "analysis/query/query_history.h"

#include <string.h>

#include "analysis/query/query_rows.h"
#include "base/alloc.h"
#include "history/history_gather.h"
#include "io/map/map_history.h"
#include "io/map/map_memory.h"

/* Outcomes on dictionaries are kept up to this, in all threads; then all are forgotten. */
enum { DECISION_NBYTES_MAX = 48 << 20 };

static const rmap_column_set segment_columns = RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
                                               RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
                                               RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);

/* What was found out of a piece's dictionary. */
struct decision {
    size_t n_path;
    uint8_t *outcome; /* [n_criterion][n_path], NULL: not yet evaluated */
    size_t
        *first_row[RMAP_TABLE_HISTORY_COUNT]; /* [n_path], NULL: not yet added up; /ray has none */
};

struct rmap_query_history {
    const struct rmap_map *map;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct decision *decision; /* [n_piece] */
    size_t decision_nbytes;
    struct rmap_query_rows *by_class;
    struct rmap_evaluator evaluator;

    size_t piece;                           /* in hand, if index is not NULL */
    const struct rmap_history_index *index; /* borrowed from the map until given back */
    struct rmap_history_reader reader;
    bool is_begun; /* by_class has the portion in hand */
    struct rmap_portion *unfolded;
    bool is_begun_rays;
    rmap_column_set present;  /* columns of the rays */
    rmap_column_set own;      /* of these, the unfolded ones */
    struct rmap_portion rays; /* the portion in hand as input */
};

enum rmap_status rmap_query_history_create(const struct rmap_map *map,
                                           const struct rmap_criterion *const *criterion,
                                           size_t n_criterion,
                                           struct rmap_query_history **history_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_history *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->map = map;
    self->criterion = criterion;
    self->n_criterion = n_criterion;
    self->decision = rmap_alloc(rmap_map_n_piece(map), sizeof *self->decision);
    self->unfolded = rmap_alloc(1, sizeof *self->unfolded);
    if (!self->decision || !self->unfolded) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
        goto out;
    }
    RMAP_TRY(rmap_query_rows_create(criterion, n_criterion, &self->by_class, err));
    *history_ret = self;
    self = NULL;
out:
    rmap_query_history_destroy(self);
    return st;
}

static void forget_decisions(struct rmap_query_history *self)
{
    for (size_t p = 0; self->decision && p < rmap_map_n_piece(self->map); p++) {
        rmap_free(self->decision[p].outcome);
        for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
            rmap_free(self->decision[p].first_row[t]);
        self->decision[p] = (struct decision){0};
    }
    self->decision_nbytes = 0;
}

static void leave_piece(struct rmap_query_history *self)
{
    if (self->index)
        rmap_map_history_release(self->map, self->piece);
    self->index = NULL;
}

void rmap_query_history_destroy(struct rmap_query_history *self)
{
    if (!self)
        return;
    rmap_history_reader_fini(self->map, &self->reader);
    leave_piece(self);
    forget_decisions(self);
    rmap_query_rows_destroy(self->by_class);
    rmap_evaluator_fini(&self->evaluator);
    rmap_portion_destroy(self->unfolded);
    rmap_free(self->decision);
    rmap_free(self);
}

uint64_t rmap_query_history_nbytes(const struct rmap_query_history *self)
{
    return self->reader.nbytes;
}

static enum rmap_status enter_piece(struct rmap_query_history *self, size_t piece,
                                    struct rmap_error *err)
{
    if (self->index && self->piece == piece)
        return RMAP_OK;
    leave_piece(self);
    self->piece = piece;
    enum rmap_status st = rmap_map_history(self->map, piece, &self->index, err);
    return st == RMAP_OK && self->index
               ? rmap_query_rows_enter_piece(self->by_class, self->index, err)
               : st;
}

enum rmap_status rmap_query_history_enter(struct rmap_query_history *self, size_t portion,
                                          const struct rmap_history_view **view_ret,
                                          struct rmap_error *err)
{
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    *view_ret = NULL;
    rmap_history_reader_leave(self->map, &self->reader);
    self->is_begun = false;
    self->is_begun_rays = false;
    self->present = self->own = 0;
    enum rmap_status st = enter_piece(self, (size_t)info->piece, err);
    if (st != RMAP_OK || !self->index)
        return st;
    size_t at = rmap_history_find(self->index, info->first_ray, info->n_row, info->digest);
    if (at == SIZE_MAX)
        return RMAP_OK;
    struct rmap_error why = {0};
    st = rmap_history_reader_enter(self->map, self->index, at, portion, &self->reader, &why);
    if (st == RMAP_FORMAT) { /* the columns know, too */
        rmap_map_history_blame(self->map, self->piece, &why);
        return RMAP_OK;
    }
    if (st != RMAP_OK && err)
        *err = why;
    if (st == RMAP_OK)
        *view_ret = &self->reader.view;
    return st;
}

/* Outcomes of all criteria on the dictionary of the piece in hand. */
static enum rmap_status evaluate_paths(struct rmap_query_history *self, struct decision *decision,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_criterion_input input = {.portion = rmap_history_paths(self->index),
                                               .columns = RMAP_COLUMNS_DISCRETE};
    size_t n_path = input.portion->n_row[RMAP_TABLE_RAY];
    decision->n_path = n_path;
    decision->outcome = rmap_alloc(self->n_criterion, n_path);
    if (!decision->outcome)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_path);
    self->decision_nbytes += self->n_criterion * n_path;
    for (size_t c = 0; c < self->n_criterion; c++)
        RMAP_TRY(rmap_criterion_decide(self->criterion[c], &input, &self->evaluator,
                                       decision->outcome + c * n_path, err));
out:
    return st;
}

/* The decision on the piece in hand. */
static enum rmap_status decide(struct rmap_query_history *self, struct decision **decision_ret,
                               struct rmap_error *err)
{
    struct decision *decision = &self->decision[self->piece];
    *decision_ret = decision;
    if (decision->outcome && decision->n_path == rmap_history_paths(self->index)->n_row[0])
        return RMAP_OK;
    if (decision->outcome || self->decision_nbytes > rmap_map_share(self->map, DECISION_NBYTES_MAX))
        forget_decisions(self);
    return evaluate_paths(self, decision, err);
}

/* The portion in hand, with the counts that its view has anyway. */
static void begin_rays(struct rmap_query_history *self)
{
    const struct rmap_history_view *view = &self->reader.view;
    self->rays = (struct rmap_portion){.first_ray = view->first_ray};
    memcpy(self->rays.n_row, view->n_row, sizeof view->n_row);
    if (view->segment_count && view->registration_count) { /* nobody writes to them */
        self->rays.ray.segment_count = (uint32_t *)(uintptr_t)view->segment_count;
        self->rays.ray.registration_count = (uint32_t *)(uintptr_t)view->registration_count;
        self->present =
            RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    }
    self->is_begun_rays = true;
}

/* Discrete columns of the portion in hand, unfolded when first asked for, unless the map kept them.
 * Those of segments take longer to keep than to unfold. */
static enum rmap_status unfold(void *context, rmap_column_set columns, struct rmap_error *err)
{
    struct rmap_query_history *self = context;
    const size_t portion = self->reader.portion;
    if (!self->is_begun_rays)
        begin_rays(self);
    self->present |=
        rmap_map_borrow_columns(self->map, portion, columns & ~self->present, &self->rays);
    const rmap_column_set fresh = columns & ~self->present;
    if (!fresh)
        return RMAP_OK;
    enum rmap_status st = rmap_history_unfold(&self->reader.view, fresh, self->unfolded, err);
    if (st != RMAP_OK)
        return st;
    self->own |= fresh;
    self->present |= fresh;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) /* more columns may have moved others */
        if (self->own & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&self->rays, (enum rmap_column)c) =
                rmap_portion_column(self->unfolded, (enum rmap_column)c);
    rmap_map_keep_columns(self->map, portion, fresh & ~segment_columns, &self->rays);
    return RMAP_OK;
}

enum rmap_status rmap_query_history_unfold(struct rmap_query_history *self, rmap_column_set columns,
                                           const struct rmap_portion **rows_ret,
                                           struct rmap_error *err)
{
    *rows_ret = &self->rays;
    return unfold(self, columns, err);
}

static enum rmap_status evaluate_rows(struct rmap_query_history *self, size_t c, uint8_t *outcome,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->is_begun) {
        RMAP_TRY(unfold(self, 0, err));
        rmap_query_rows_enter(self->by_class, &self->reader.view, &self->rays, unfold, self);
        self->is_begun = true;
    }
    RMAP_TRY(rmap_query_rows_evaluate(self->by_class, c, &self->evaluator, outcome, err));
out:
    return st;
}

enum rmap_status rmap_query_history_evaluate(struct rmap_query_history *self, size_t c,
                                             uint8_t *outcome, struct rmap_error *err)
{
    const struct rmap_history_view *view = &self->reader.view;
    struct decision *decision;
    if (view->form != RMAP_HISTORY_PATHS)
        return evaluate_rows(self, c, outcome, err);
    enum rmap_status st = decide(self, &decision, err);
    if (st != RMAP_OK)
        return st;
    const uint8_t *known = decision->outcome + c * decision->n_path;
    for (size_t k = 0; k < view->n_path; k++)
        outcome[k] = known[view->path_row[k]];
    return RMAP_OK;
}

/* Where the rows of the dictionary's paths begin in a table. */
static enum rmap_status add_up(struct rmap_query_history *self, struct decision *decision,
                               enum rmap_table table, struct rmap_error *err)
{
    const struct rmap_ray_columns *path = &rmap_history_paths(self->index)->ray;
    const uint32_t *rows =
        table == RMAP_TABLE_SEGMENT ? path->segment_count : path->registration_count;
    size_t *first = decision->first_row[table], at = 0;
    if (first)
        return RMAP_OK;
    first = rmap_alloc(decision->n_path, sizeof *first);
    if (!first)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", decision->n_path);
    for (size_t i = 0; i < decision->n_path; at += rows[i++])
        first[i] = at;
    decision->first_row[table] = first;
    self->decision_nbytes += decision->n_path * sizeof *first;
    return RMAP_OK;
}

enum rmap_status rmap_query_history_know(struct rmap_query_history *self, rmap_column_set columns,
                                         struct rmap_known_rows *known, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct decision *decision;
    *known = (struct rmap_known_rows){.portion = &self->rays};
    if (self->reader.view.form != RMAP_HISTORY_PATHS)
        return unfold(self, columns, err);
    known->portion = rmap_history_paths(self->index);
    RMAP_TRY(decide(self, &decision, err));
    for (int t = RMAP_TABLE_SEGMENT; t < RMAP_TABLE_HISTORY_COUNT; t++) {
        RMAP_TRY(add_up(self, decision, (enum rmap_table)t, err));
        known->first_row[t] = decision->first_row[t];
    }
out:
    return st;
}
