/* SPDX-License-Identifier: MIT */
#include "mpi/gather.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/agree.h"

enum { TAG_COLUMN = 1 };

static enum rmap_status reserve(struct rmap_portion *portion, const uint64_t n_row[],
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int table = 0; table < RMAP_TABLE_COUNT && st == RMAP_OK; table++)
        st = rmap_portion_reserve(portion, (enum rmap_table)table, (size_t)n_row[table],
                                  RMAP_COLUMNS_ALL, err);
    return st;
}

static enum rmap_table table_of(int column)
{
    return rmap_column_info((enum rmap_column)column)->table;
}

/* Where the next row of a column goes. */
static unsigned char *column_end(struct rmap_portion *portion, int column)
{
    size_t row_nbytes = rmap_portion_row_nbytes(portion, (enum rmap_column)column);
    unsigned char *start = rmap_portion_column(portion, (enum rmap_column)column);
    return start + row_nbytes * portion->n_row[table_of(column)];
}

static void add_rows(struct rmap_portion *portion, const uint64_t n_row[])
{
    for (int table = 0; table < RMAP_TABLE_COUNT; table++)
        portion->n_row[table] += (size_t)n_row[table];
}

static void row_counts(const struct rmap_portion *portion, uint64_t n_row[])
{
    for (int table = 0; table < RMAP_TABLE_COUNT; table++)
        n_row[table] = portion->n_row[table];
}

enum rmap_status rmap_portion_append(struct rmap_portion *dst, const struct rmap_portion *src,
                                     struct rmap_error *err)
{
    uint64_t n_row[RMAP_TABLE_COUNT];
    row_counts(src, n_row);
    enum rmap_status st = reserve(dst, n_row, err);
    if (st != RMAP_OK)
        return st;
    for (int column = 0; column < RMAP_COLUMN_COUNT; column++) {
        size_t nbytes =
            rmap_portion_row_nbytes(src, (enum rmap_column)column) * src->n_row[table_of(column)];
        if (nbytes > 0)
            memcpy(column_end(dst, column), rmap_portion_column(src, (enum rmap_column)column),
                   nbytes);
    }
    if (dst->n_row[RMAP_TABLE_RAY] == 0)
        dst->first_ray = src->first_ray;
    add_rows(dst, n_row);
    return RMAP_OK;
}

void rmap_portion_truncate(struct rmap_portion *portion, size_t n)
{
    size_t *n_row = portion->n_row;
    while (n_row[RMAP_TABLE_RAY] > n) {
        size_t last = --n_row[RMAP_TABLE_RAY];
        n_row[RMAP_TABLE_SEGMENT] -= portion->ray.segment_count[last];
        n_row[RMAP_TABLE_REGISTRATION] -= portion->ray.registration_count[last];
    }
}

/* MPI counts are int: long columns travel in pieces. */
static enum rmap_status transfer(const struct rmap_context *context, unsigned char *bytes,
                                 size_t nbytes, int from, struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 30;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < nbytes; at += piece) {
        int len = (int)(nbytes - at < piece ? nbytes - at : piece);
        if (context->rank == 0)
            RMAP_TRY(RMAP_MPI(MPI_Recv(bytes + at, len, MPI_BYTE, from, TAG_COLUMN, context->comm,
                                       MPI_STATUS_IGNORE)));
        else
            RMAP_TRY(RMAP_MPI(MPI_Send(bytes + at, len, MPI_BYTE, 0, TAG_COLUMN, context->comm)));
    }
out:
    return st;
}

/* Rank 0: takes the rows of one rank. */
static enum rmap_status receive(const struct rmap_context *context, struct rmap_portion *portion,
                                int from, const uint64_t n_row[], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int column = 0; column < RMAP_COLUMN_COUNT; column++) {
        size_t nbytes = rmap_portion_row_nbytes(portion, (enum rmap_column)column) *
                        (size_t)n_row[table_of(column)];
        RMAP_TRY(transfer(context, column_end(portion, column), nbytes, from, err));
    }
    add_rows(portion, n_row);
out:
    return st;
}

static enum rmap_status send_all(const struct rmap_context *context, struct rmap_portion *portion,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int column = 0; column < RMAP_COLUMN_COUNT; column++) {
        size_t nbytes = rmap_portion_row_nbytes(portion, (enum rmap_column)column) *
                        portion->n_row[table_of(column)];
        RMAP_TRY(transfer(context, rmap_portion_column(portion, (enum rmap_column)column), nbytes,
                          context->rank, err));
    }
out:
    return st;
}

enum rmap_status rmap_gather_portion(const struct rmap_context *context,
                                     struct rmap_portion *portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t mine[RMAP_TABLE_COUNT], total[RMAP_TABLE_COUNT] = {0};
    uint64_t *all = rmap_alloc((size_t)context->size, sizeof mine);
    row_counts(portion, mine);
    if (!all)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Gather(mine, RMAP_TABLE_COUNT, MPI_UINT64_T, all, RMAP_TABLE_COUNT,
                                 MPI_UINT64_T, 0, context->comm)));
    for (int i = RMAP_TABLE_COUNT; context->rank == 0 && i < context->size * RMAP_TABLE_COUNT; i++)
        total[i % RMAP_TABLE_COUNT] += all[i];
    if (context->rank == 0) /* room for everything first: nothing fails once ranks send */
        st = reserve(portion, total, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank != 0)
        st = send_all(context, portion, err);
    for (int from = 1; context->rank == 0 && from < context->size && st == RMAP_OK; from++)
        st = receive(context, portion, from, all + from * RMAP_TABLE_COUNT, err);
    RMAP_TRY(st);
out:
    rmap_free(all);
    return st;
}
