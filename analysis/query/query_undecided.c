/* SPDX-License-Identifier: MIT
 *
 * The rays of a portion that its history leaves undecided: discrete columns from the index,
 * measured ones from the map, each when first asked for.
 */
#include "analysis/query/query_undecided.h"

#include <string.h>

#include "base/alloc.h"
#include "base/wide.h"
#include "history/history_view.h"
#include "io/map/map_cursor.h"

enum { MANY_SHARE = 6 };

/* A ray's rows in a table: where they stand in the map's portion, and where they are known. */
struct rmap_row_range {
    size_t stored, known;
    uint32_t n;
};

void rmap_undecided_fini(struct rmap_undecided *self)
{
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        rmap_free(self->range[t]);
    rmap_free(self->ray);
    rmap_portion_destroy(self->memory);
    *self = (struct rmap_undecided){0};
}

RMAP_WIDE static uint32_t count_open(const uint8_t *outcome, size_t n)
{
    uint32_t n_open = 0;
    for (size_t i = 0; i < n; i++)
        n_open += outcome[i] == RMAP_OUTCOME_OPEN;
    return n_open;
}

/* Gathering a ray costs as much as some rays in their places. */
static bool is_many(const struct rmap_history_view *view, const uint8_t *outcome)
{
    size_t n_open = 0;
    if (view->form == RMAP_HISTORY_PATHS)
        for (size_t k = 0; k < view->n_path; k++)
            n_open += outcome[k] == RMAP_OUTCOME_OPEN ? view->path_rays[k] : 0;
    else
        n_open = count_open(outcome, view->n_row[RMAP_TABLE_RAY]);
    return n_open > view->n_row[RMAP_TABLE_RAY] / MANY_SHARE;
}

enum rmap_status rmap_undecided_enter(struct rmap_undecided *self, const uint8_t *outcome,
                                      const struct rmap_history_view *view,
                                      struct rmap_query_history *history, struct rmap_error *err)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY], n = 0;
    enum rmap_status st = RMAP_RESERVE(self->ray, self->ray_cap, n_ray + 1, err);
    if (st != RMAP_OK)
        return st;
    if (!self->memory && !(self->memory = rmap_alloc(1, sizeof *self->memory)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    bool by_path = view->form == RMAP_HISTORY_PATHS;
    self->is_whole = is_many(view, outcome);
    for (size_t i = 0; !self->is_whole && i < n_ray; i++) { /* one more than counts is written */
        self->ray[n] = (uint32_t)i;
        n += outcome[by_path ? view->path[i] : i] == RMAP_OUTCOME_OPEN;
    }
    if (self->is_whole)
        n = n_ray;
    self->n = n;
    self->view = view;
    self->history = history;
    self->present = 0;
    memset(self->is_placed, 0, sizeof self->is_placed);
    rmap_portion_clear(self->memory);
    self->rows = (struct rmap_portion){.first_ray = view->first_ray, .n_row[RMAP_TABLE_RAY] = n};
    if (self->is_whole)
        memcpy(self->rows.n_row, view->n_row, sizeof view->n_row);
    return RMAP_OK;
}

/* Rows per ray of a table, known from the index: of row i where rays are known. */
static const uint32_t *known_counts(const struct rmap_known_rows *known, enum rmap_table table)
{
    return table == RMAP_TABLE_SEGMENT ? known->portion->ray.segment_count
                                       : known->portion->ray.registration_count;
}

/* Finds the rows of the undecided rays in a table. */
static enum rmap_status place(struct rmap_undecided *self, enum rmap_table table,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_history_view *view = self->view;
    const bool by_path = view->form == RMAP_HISTORY_PATHS, is_ray = table == RMAP_TABLE_RAY;
    struct rmap_known_rows known;
    size_t at = 0, n = 0;
    if (self->is_placed[table])
        return RMAP_OK;
    RMAP_TRY(rmap_query_history_know(self->history,
                                     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                                         RMAP_COLUMN_BIT(RMAP_RAY_registration_count),
                                     &known, err));
    RMAP_TRY(RMAP_RESERVE(self->range[table], self->range_cap[table], self->n + 1, err));
    const uint32_t *count = is_ray ? NULL : known_counts(&known, table);
    for (size_t s = 0, i = 0; s < self->n; s++) {
        for (; count && i < self->ray[s]; i++)
            at += count[by_path ? view->path_row[view->path[i]] : i];
        size_t ray = self->ray[s], row = by_path ? view->path_row[view->path[ray]] : ray;
        self->range[table][s] =
            is_ray ? (struct rmap_row_range){ray, row, 1}
                   : (struct rmap_row_range){at, by_path ? known.first_row[table][row] : at,
                                             count[row]};
        n += self->range[table][s].n;
    }
    self->rows.n_row[table] = n;
    self->is_placed[table] = true;
out:
    return st;
}

/* Rows of `from` that the ranges name, side by side. With a constant size no copy is a call. */
static inline void gather_rows(const struct rmap_row_range *range, size_t n, size_t row_nbytes,
                               bool is_known, const char *from, char *to)
{
    for (size_t s = 0; s < n; s++) {
        const char *row = from + (is_known ? range[s].known : range[s].stored) * row_nbytes;
        for (uint32_t r = 0; r < range[s].n; r++, row += row_nbytes, to += row_nbytes)
            memcpy(to, row, row_nbytes);
    }
}

static void gather(const struct rmap_row_range *range, size_t n, size_t row_nbytes, bool is_known,
                   const void *from, void *to)
{
    switch (row_nbytes) {
    case 1:
        gather_rows(range, n, 1, is_known, from, to);
        return;
    case 2:
        gather_rows(range, n, 2, is_known, from, to);
        return;
    case 4:
        gather_rows(range, n, 4, is_known, from, to);
        return;
    case 8:
        gather_rows(range, n, 8, is_known, from, to);
        return;
    default:
        gather_rows(range, n, row_nbytes, is_known, from, to);
    }
}

/* The measured column of the whole portion. */
static enum rmap_status read_measured(struct rmap_undecided *self, enum rmap_column column,
                                      void **from_ret, struct rmap_error *err)
{
    if (column == RMAP_REGISTRATION_relative && self->view->relative) {
        *from_ret = (void *)(uintptr_t)self->view->relative; /* nobody writes to it */
        return RMAP_OK;
    }
    enum rmap_status st = rmap_cursor_fetch(self->cursor, RMAP_COLUMN_BIT(column), err);
    *from_ret = rmap_portion_column(self->measured, column);
    return st;
}

static enum rmap_status gather_column(struct rmap_undecided *self, enum rmap_column column,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    enum rmap_table table = rmap_column_info(column)->table;
    const bool is_known = (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(column)) != 0;
    struct rmap_known_rows known;
    void *from;
    RMAP_TRY(place(self, table, err));
    self->memory->n_row[table] = 0;
    RMAP_TRY(rmap_portion_reserve(self->memory, table, self->rows.n_row[table] + 1,
                                  RMAP_COLUMN_BIT(column), err));
    if (is_known) {
        RMAP_TRY(rmap_query_history_know(self->history, RMAP_COLUMN_BIT(column), &known, err));
        from = rmap_portion_column(known.portion, column);
    } else {
        RMAP_TRY(read_measured(self, column, &from, err));
    }
    if (self->rows.n_row[table] > 0)
        gather(self->range[table], self->n, rmap_portion_row_nbytes(self->memory, column), is_known,
               from, rmap_portion_column(self->memory, column));
    self->present |= RMAP_COLUMN_BIT(column);
out:
    return st;
}

/* Columns of all rays stay where they are read or unfolded to. */
static enum rmap_status borrow_columns(struct rmap_undecided *self, rmap_column_set columns,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *unfolded;
    RMAP_TRY(
        rmap_query_history_unfold(self->history, columns & RMAP_COLUMNS_DISCRETE, &unfolded, err));
    self->present |= columns;
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column column = (enum rmap_column)i;
        void *from;
        if (!(self->present & RMAP_COLUMN_BIT(column)))
            continue;
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(column))
            from = rmap_portion_column(unfolded, column);
        else
            RMAP_TRY(read_measured(self, column, &from, err));
        *rmap_portion_column_address(&self->rows, column) = from;
    }
out:
    return st;
}

enum rmap_status rmap_undecided_fetch(void *context, rmap_column_set columns,
                                      struct rmap_error *err)
{
    struct rmap_undecided *self = context;
    rmap_column_set fresh = columns & ~self->present;
    enum rmap_status st = RMAP_OK;
    if (self->is_whole)
        return fresh ? borrow_columns(self, fresh, err) : RMAP_OK;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (fresh & RMAP_COLUMN_BIT(c))
            RMAP_TRY(gather_column(self, (enum rmap_column)c, err));
    for (int c = 0; fresh && c < RMAP_COLUMN_COUNT; c++) /* more columns may have moved others */
        if (self->present & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&self->rows, (enum rmap_column)c) =
                rmap_portion_column(self->memory, (enum rmap_column)c);
out:
    return st;
}
