/* SPDX-License-Identifier: MIT
 *
 * Columns of the portion in hand.
 */
#include "analysis/query/query_verdicts_internal.h"

uint64_t rmap_query_verdicts_nbytes(const struct rmap_query_verdicts *self)
{
    return rmap_query_history_nbytes(self->history) + rmap_cursor_nbytes_of_rows(self->cursor);
}

enum rmap_status rmap_query_verdicts_enter_columns(struct rmap_query_verdicts *self,
                                                   struct rmap_error *err)
{
    if (self->is_entered)
        return RMAP_OK;
    enum rmap_status st = rmap_cursor_enter(self->cursor, self->index, &self->portion, err);
    self->is_entered = st == RMAP_OK;
    return st;
}

enum rmap_status rmap_query_verdicts_fetch(void *context, rmap_column_set columns,
                                           struct rmap_error *err)
{
    struct rmap_query_verdicts *self = context;
    return rmap_cursor_fetch(self->cursor, columns, err);
}

enum rmap_status rmap_query_verdicts_read(struct rmap_query_verdicts *self, rmap_column_set columns,
                                          const struct rmap_portion **portion_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = rmap_query_verdicts_enter_columns(self, err);
    *portion_ret = self->portion;
    return st == RMAP_OK ? rmap_query_verdicts_fetch(self, columns, err) : st;
}

enum rmap_status rmap_query_verdicts_know(struct rmap_query_verdicts *self, rmap_column_set columns,
                                          const struct rmap_portion **portion_ret,
                                          struct rmap_error *err)
{
    const rmap_column_set discrete = self->view ? columns & RMAP_COLUMNS_DISCRETE : 0;
    const struct rmap_portion *known = NULL;
    enum rmap_status st = rmap_query_verdicts_read(self, columns & ~discrete, portion_ret, err);
    if (st != RMAP_OK || !self->view)
        return st;
    st = rmap_query_history_unfold(self->history, discrete, &known, err);
    if (st != RMAP_OK)
        return st;
    self->known |= discrete;
    self->joined = *self->portion;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->known & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&self->joined, (enum rmap_column)c) =
                rmap_portion_column(known, (enum rmap_column)c);
    *portion_ret = &self->joined;
    return RMAP_OK;
}

enum rmap_status rmap_query_verdicts_weigh(struct rmap_query_verdicts *self, bool *are_one_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = rmap_query_verdicts_enter_columns(self, err);
    return st == RMAP_OK ? rmap_cursor_weigh(self->cursor, are_one_ret, err) : st;
}

enum rmap_status rmap_query_verdicts_cursor(struct rmap_query_verdicts *self,
                                            struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    *cursor_ret = self->cursor;
    return rmap_query_verdicts_enter_columns(self, err);
}

const struct rmap_history_view *rmap_query_verdicts_view(const struct rmap_query_verdicts *self)
{
    return self->view;
}
