/* SPDX-License-Identifier: MIT
 *
 * A portion as one block of bytes that travels between ranks of one program.
 */
#include "mpi/parallel/message.h"

#include <string.h>

#include "base/alloc.h"

struct header {
    uint64_t first_ray, n_row[RMAP_TABLE_COUNT], n_channel, timed;
    rmap_column_set columns;
};

/* Columns begin at multiples of 8 bytes. */
static size_t column_nbytes(const struct rmap_portion *portion, enum rmap_column column)
{
    size_t rows = portion->n_row[rmap_column_info(column)->table];
    return (rows * rmap_portion_row_nbytes(portion, column) + 7) / 8 * 8;
}

static size_t message_nbytes(const struct rmap_portion *portion, rmap_column_set columns)
{
    size_t nbytes = sizeof(struct header);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        nbytes += columns >> c & 1 ? column_nbytes(portion, (enum rmap_column)c) : 0;
    return nbytes;
}

enum rmap_status rmap_message_create(size_t nbytes, struct rmap_message **message_ret,
                                     struct rmap_error *err)
{
    struct rmap_message *message = rmap_alloc(1, sizeof *message);
    if (message)
        message->bytes = rmap_alloc(nbytes, 1);
    if (!message || !message->bytes) {
        rmap_free(message);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block of %zu bytes", nbytes);
    }
    message->nbytes = nbytes;
    *message_ret = message;
    return RMAP_OK;
}

void rmap_message_destroy(struct rmap_message *message)
{
    if (!message)
        return;
    rmap_free(message->bytes);
    rmap_free(message);
}

enum rmap_status rmap_message_pack(const struct rmap_portion *portion, rmap_column_set columns,
                                   struct rmap_message **message_ret, struct rmap_error *err)
{
    struct rmap_message *message = NULL;
    columns &= rmap_columns_of_run(portion->timed);
    enum rmap_status st = rmap_message_create(message_nbytes(portion, columns), &message, err);
    if (st != RMAP_OK)
        return st;
    struct header header = {.first_ray = portion->first_ray,
                            .n_channel = (uint64_t)portion->n_channel,
                            .timed = portion->timed,
                            .columns = columns};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        header.n_row[t] = portion->n_row[t];
    memcpy(message->bytes, &header, sizeof header);
    size_t at = sizeof header;
    for (; columns; columns &= columns - 1) {
        const enum rmap_column c = (enum rmap_column)__builtin_ctzll(columns);
        size_t rows = portion->n_row[rmap_column_info(c)->table];
        if (rows > 0)
            memcpy(message->bytes + at, rmap_portion_column(portion, c),
                   rows * rmap_portion_row_nbytes(portion, c));
        at += column_nbytes(portion, c);
    }
    *message_ret = message;
    return RMAP_OK;
}

enum rmap_status rmap_message_view(const struct rmap_message *message, struct rmap_portion *view,
                                   struct rmap_error *err)
{
    struct header header = {0};
    *view = (struct rmap_portion){0};
    bool fits = message->nbytes >= sizeof header;
    if (fits)
        memcpy(&header, message->bytes, sizeof header);
    fits = fits && header.n_channel >= 1 && header.n_channel <= UINT16_MAX;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        view->n_row[t] = (size_t)header.n_row[t];
    view->first_ray = header.first_ray;
    view->n_channel = fits ? (int)header.n_channel : 1;
    view->timed = header.timed != 0;
    fits = fits && !(header.columns & ~rmap_columns_of_run(view->timed));
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        fits =
            fits && (!(header.columns >> c & 1) ||
                     view->n_row[rmap_column_info((enum rmap_column)c)->table] <= message->nbytes);
    if (!fits || message_nbytes(view, header.columns) != message->nbytes)
        return rmap_error_set(err, RMAP_INTERNAL, "a block from another rank is torn");
    size_t at = sizeof header;
    for (rmap_column_set left = header.columns; left; left &= left - 1) {
        const enum rmap_column c = (enum rmap_column)__builtin_ctzll(left);
        void *start = message->bytes + at;
        memcpy((void *)rmap_portion_column_address(view, c), &start, sizeof start);
        at += column_nbytes(view, c);
    }
    return RMAP_OK;
}
