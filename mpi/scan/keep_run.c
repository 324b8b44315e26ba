/* SPDX-License-Identifier: MIT
 *
 * Writing columns of a map's compact pieces beside them.
 */
#include "mpi/scan/keep_run.h"

#include <stdatomic.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_cursor.h"
#include "io/map/piece_columns.h"
#include "io/write/columns_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"

/* Portions in memory at once, per thread. */
enum { AT_ONCE = 8 };

struct keeping {
    const struct rmap_map *map;
    rmap_column_set columns; /* of the piece in hand */
    bool anew;               /* from the piece, whatever stands beside it */
    size_t *portion;         /* [n_portion] of the piece in hand, in the map's order */
    size_t n_portion, cap_portion;
    size_t at;                   /* of these, where the wave begins */
    struct rmap_portion **rows;  /* [n_rows] of the wave */
    struct rmap_cursor **cursor; /* [n_thread] */
    size_t n_rows;
    int n_thread;
    struct rmap_progress progress;
    _Atomic uint64_t done; /* rays */
};

static enum rmap_status copy_columns(const struct rmap_portion *from, rmap_column_set columns,
                                     struct rmap_portion *to, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_portion_clear(to);
    to->n_channel = from->n_channel;
    to->timed = from->timed;
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(to, (enum rmap_table)t, from->n_row[t], columns, err));
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        to->n_row[t] = from->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const size_t n = from->n_row[rmap_column_info((enum rmap_column)c)->table];
        if (columns & RMAP_COLUMN_BIT(c) && n > 0)
            memcpy(rmap_portion_column(to, (enum rmap_column)c),
                   rmap_portion_column(from, (enum rmap_column)c),
                   n * rmap_portion_row_nbytes(from, (enum rmap_column)c));
    }
out:
    return st;
}

/* On any thread: portions of the wave. */
static enum rmap_status decode(void *context, int thread, size_t first, size_t last,
                               struct rmap_error *err)
{
    struct keeping *self = context;
    enum rmap_status st = RMAP_OK;
    const rmap_column_set all =
        self->anew ? rmap_keepable_columns() : 0; /* of them, what the map has */
    if (!self->cursor[thread])
        RMAP_TRY(rmap_cursor_create(self->map, self->columns | all, &self->cursor[thread], err));
    for (size_t i = first; i < last; i++) {
        const struct rmap_portion *rows;
        const size_t portion = self->portion[self->at + i];
        RMAP_TRY(rmap_cursor_enter(self->cursor[thread], portion, &rows, err));
        RMAP_TRY(rmap_cursor_fetch(self->cursor[thread], self->columns, err));
        RMAP_TRY(copy_columns(rows, self->columns, self->rows[i], err));
        atomic_fetch_add(&self->done, rows->n_row[RMAP_TABLE_RAY]);
    }
out:
    return st;
}

static enum rmap_status show(void *context, struct rmap_error *err)
{
    struct keeping *self = context;
    (void)err;
    rmap_progress_show(&self->progress, atomic_load(&self->done));
    return RMAP_OK;
}

static enum rmap_status list_portions(struct keeping *self, size_t piece, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->n_portion = 0;
    for (size_t i = 0; st == RMAP_OK && i < rmap_map_n_portion(self->map); i++)
        if ((size_t)rmap_map_portion(self->map, i)->piece == piece) {
            st = RMAP_RESERVE(self->portion, self->cap_portion, self->n_portion + 1, err);
            if (st == RMAP_OK)
                self->portion[self->n_portion++] = i;
        }
    return st;
}

/* Every thread's cursor is of one set of columns. */
static void let_cursors_go(struct keeping *self)
{
    for (int k = 0; k < self->n_thread; k++) {
        rmap_cursor_destroy(self->cursor[k]);
        self->cursor[k] = NULL;
    }
}

static enum rmap_status write_piece(struct keeping *self, size_t piece, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_columns_writer *writer = NULL;
    let_cursors_go(self);
    RMAP_TRY(list_portions(self, piece, err));
    RMAP_TRY(rmap_columns_writer_create(self->map, piece, self->columns, &writer, err));
    for (self->at = 0; self->at < self->n_portion; self->at += self->n_rows) {
        const size_t left = self->n_portion - self->at;
        struct rmap_parts parts = {.last = left < self->n_rows ? left : self->n_rows,
                                   .step = 1,
                                   .context = self,
                                   .work = decode,
                                   .meanwhile = show};
        RMAP_TRY(rmap_parts_run(&parts, self->n_thread, err));
        for (size_t i = 0; i < parts.last; i++)
            RMAP_TRY(rmap_columns_writer_put(writer, self->rows[i], err));
    }
    st = rmap_columns_writer_finish(writer, err);
out:
    rmap_columns_writer_destroy(writer);
    return st;
}

static double piece_rows(void *context, size_t piece)
{
    const struct rmap_piece_info *info = rmap_map_piece(((struct keeping *)context)->map, piece);
    return (double)(info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
}

static enum rmap_status reserve(struct keeping *self, struct rmap_error *err)
{
    self->n_rows = (size_t)self->n_thread * AT_ONCE;
    self->cursor = rmap_alloc((size_t)self->n_thread, sizeof(void *));
    self->rows = rmap_alloc(self->n_rows, sizeof(void *));
    for (size_t i = 0; self->rows && i < self->n_rows; i++)
        if (!(self->rows[i] = rmap_alloc(1, sizeof **self->rows)))
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
    return self->rows && self->cursor
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for kept columns");
}

static void release(struct keeping *self)
{
    if (self->cursor)
        let_cursors_go(self);
    for (size_t i = 0; self->rows && i < self->n_rows; i++)
        rmap_portion_destroy(self->rows[i]);
    rmap_free(self->rows);
    rmap_free(self->cursor);
    rmap_free(self->portion);
}

/* This rank's pieces. */
static enum rmap_status keep_pieces(struct keeping *self, const struct rmap_parts *share,
                                    rmap_column_set columns, bool force,
                                    struct rmap_keep_result *result, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(reserve(self, err));
    for (size_t i = share->first; i < share->last; i++) {
        const struct rmap_piece_info *info = rmap_map_piece(self->map, i);
        const rmap_column_set beside = rmap_map_columns_beside(self->map, i);
        if (info->is_open || info->encoding != RMAP_ENCODING_COMPACT)
            continue;
        result->n_piece++;
        self->columns = columns | beside;
        if ((columns & ~beside) || force) {
            RMAP_TRY(write_piece(self, i, err));
            result->n_made++;
        }
    }
out:
    return st;
}

enum rmap_status rmap_keep_run(const struct rmap_context *context, const struct rmap_map *map,
                               rmap_column_set columns, bool force, struct rmap_keep_result *result,
                               struct rmap_error *err)
{
    struct keeping self = {.map = map, .n_thread = context->n_thread, .anew = force};
    struct rmap_parts share = {0};
    const double begun = rmap_clock_seconds();
    uint64_t n_ray = 0;
    *result = (struct rmap_keep_result){0};
    share.context = &self;
    rmap_parts_share(&share, piece_rows, rmap_map_n_piece(map), context->rank, context->size);
    for (size_t i = share.first; i < share.last; i++)
        n_ray += rmap_map_piece(map, i)->n_row[RMAP_TABLE_RAY];
    rmap_progress_init(&self.progress, context, "rays", n_ray);
    enum rmap_status st = keep_pieces(&self, &share, columns, force, result, err);
    rmap_progress_fini(&self.progress);
    release(&self);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    uint64_t sum[] = {result->n_piece, result->n_made};
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_UINT64_T, MPI_SUM, context->comm)));
    result->n_piece = sum[0];
    result->n_made = sum[1];
    result->seconds = rmap_clock_seconds() - begun;
out:
    return st;
}
