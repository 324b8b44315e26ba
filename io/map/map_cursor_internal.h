/* SPDX-License-Identifier: MIT
 *
 * What map_cursor.c and map_cursor_compact.c share.
 */
#ifndef RMAP_MAP_CURSOR_INTERNAL_H
#define RMAP_MAP_CURSOR_INTERNAL_H

#include "io/map/chunk_reader.h"
#include "io/map/map_internal.h"

/* What a colour space takes; made when first needed. */
struct rmap_cursor_space {
    struct rmap_portion *portion;
    struct rmap_compact_decoder *decoder;
};

/* A stream's rows of the portion in hand, for the decoder. */
struct rmap_row_buffer {
    void *data;
    size_t cap; /* bytes */
};

struct rmap_cursor {
    const struct rmap_map *map;
    rmap_column_set columns;
    struct rmap_chunk_reader *reader;
    struct rmap_cursor_space *space; /* [n_space] */
    size_t in_hand;                  /* portion of the map */
    rmap_column_set present;         /* columns of it that have been read */
    rmap_column_set kept;            /* and those that the map's store lends */
    uint64_t streams;                /* of a compact one, in `buffer` */
    struct rmap_portion *portion;    /* of the space in hand; borrowed from there */
    struct rmap_portion shown;       /* that, without columns that only decoding needed */
    struct rmap_row_buffer buffer[RMAP_STREAM_MAX];
    const struct rmap_path_table *paths; /* of a compact piece; NULL: none in hand */
    size_t paths_piece;                  /* whose they are */
    struct rmap_portion *own;            /* rays with paths of their own, */
    bool has_own;                        /* of the portion in hand */
};

/* Gives the paths in hand back, unless they are those of that piece. */
void rmap_cursor_leave_paths(struct rmap_cursor *cursor, size_t piece);

/* Decodes columns of a portion of a compact piece into cursor->portion, where those that are
 * present stay. */
enum rmap_status rmap_cursor_read_compact(struct rmap_cursor *cursor,
                                          const struct rmap_portion_info *info,
                                          rmap_column_set columns,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Values of a column of rows of that portion must name something of the scene. */
enum rmap_status rmap_cursor_check_limits(const struct rmap_cursor *cursor,
                                          const struct rmap_portion *rows, enum rmap_column column,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
