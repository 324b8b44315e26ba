/* SPDX-License-Identifier: MIT
 *
 * The rows of a block's parts, from when they are recorded to when the block is appended: kept
 * past the caches, which they would take from the scene.
 */
#include "io/write/row_parts.h"

#include <string.h>

#include "base/alloc.h"

#define LINE 64 /* bytes that are written at once, and where columns begin */

struct part {
    uint8_t *block; /* its columns, in their order, each from a line of its own on */
    size_t nbytes;  /* of the block */
    size_t n_row[RMAP_TABLE_COUNT];
};

struct rmap_row_parts {
    enum rmap_colour_mode mode;
    int n_channel;
    bool timed;
    struct part *part; /* [cap]; those from n on have but a block */
    size_t n, cap;
};

enum rmap_status rmap_row_parts_create(enum rmap_colour_mode mode,
                                       struct rmap_row_parts **parts_ret, struct rmap_error *err)
{
    struct rmap_row_parts *parts = rmap_alloc(1, sizeof *parts);
    if (!parts)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block");
    parts->mode = mode;
    *parts_ret = parts;
    return RMAP_OK;
}

void rmap_row_parts_destroy(struct rmap_row_parts *parts)
{
    if (!parts)
        return;
    for (size_t i = 0; i < parts->cap; i++)
        rmap_free(parts->part[i].block);
    rmap_free(parts->part);
    rmap_free(parts);
}

void rmap_row_parts_clear(struct rmap_row_parts *parts)
{
    parts->n = 0;
}

size_t rmap_row_parts_count(const struct rmap_row_parts *parts)
{
    return parts->n;
}

static size_t to_line(size_t nbytes)
{
    return (nbytes + LINE - 1) / LINE * LINE;
}

static uint8_t *first_line(uint8_t *block)
{
    return block + -(uintptr_t)block % LINE;
}

static size_t column_nbytes(const struct rmap_portion *portion, int column)
{
    return portion->n_row[rmap_column_info((enum rmap_column)column)->table] *
           rmap_portion_row_nbytes(portion, (enum rmap_column)column);
}

/* A place for one part more, with room for so many bytes of columns. */
static enum rmap_status make_room(struct rmap_row_parts *parts, size_t nbytes,
                                  struct rmap_error *err)
{
    if (parts->n == parts->cap) {
        size_t cap = parts->cap;
        enum rmap_status st = RMAP_RESERVE(parts->part, cap, cap + 1, err);
        if (st != RMAP_OK)
            return st;
        memset(parts->part + parts->cap, 0, (cap - parts->cap) * sizeof *parts->part);
        parts->cap = cap;
    }
    struct part *part = &parts->part[parts->n];
    if (part->nbytes >= nbytes + LINE)
        return RMAP_OK;
    rmap_free(part->block);
    part->nbytes = nbytes + nbytes / 4 + LINE; /* the next block's will not be quite the same */
    part->block = rmap_alloc_unset(part->nbytes, 1);
    if (part->block)
        return RMAP_OK;
    part->nbytes = 0;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the histories of a block");
}

enum rmap_status rmap_row_parts_add(struct rmap_row_parts *parts, const struct rmap_portion *part,
                                    struct rmap_error *err)
{
    size_t nbytes = 0;
    const int n_column = part->timed ? RMAP_COLUMN_COUNT : RMAP_RAY_group_path;
    for (int c = 0; c < n_column; c++)
        nbytes += to_line(column_nbytes(part, c));
    enum rmap_status st = make_room(parts, nbytes, err);
    if (st != RMAP_OK)
        return st;
    struct part *kept = &parts->part[parts->n++];
    memcpy(kept->n_row, part->n_row, sizeof kept->n_row);
    parts->n_channel = part->n_channel;
    parts->timed = part->timed;
    uint8_t *to = first_line(kept->block);
    for (int c = 0; c < n_column; c++) {
        size_t n = column_nbytes(part, c);
        if (n > 0)
            memcpy(to, rmap_portion_column(part, (enum rmap_column)c), n);
        to += to_line(n);
    }
    return RMAP_OK;
}

void rmap_row_parts_rows(const struct rmap_row_parts *parts, size_t i, struct rmap_rows *rows)
{
    const struct part *part = &parts->part[i];
    *rows = (struct rmap_rows){.layout = rmap_layout_of(RMAP_ENCODING_PLAIN, parts->mode),
                               .n_channel = parts->n_channel};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rows->n_row[t] = part->n_row[t];
    rows->n_row[RMAP_PLAIN_RAY_TIME] = parts->timed ? part->n_row[RMAP_TABLE_RAY] : 0;
    rows->n_row[RMAP_PLAIN_REGISTRATION_TIME] =
        parts->timed ? part->n_row[RMAP_TABLE_REGISTRATION] : 0;
    uint8_t *at = first_line(part->block);
    for (int s = 0; s < rows->layout->n_stream; s++) {
        const struct rmap_stream_info *stream = &rows->layout->stream[s];
        rows->data[s] = at;
        at += to_line(rows->n_row[stream->table] * rmap_stream_row_nbytes(stream, rows->n_channel));
    }
}
