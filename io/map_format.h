/* SPDX-License-Identifier: MIT
 *
 * What writer and reader of a map agree on; docs/map.md says the same in words.
 */
#ifndef RMAP_MAP_FORMAT_H
#define RMAP_MAP_FORMAT_H

#include <stddef.h>
#include <stdint.h>

#include "io/h5.h"
#include "io/map_reader.h"

#define RMAP_FILETYPE_PIECE "raymap piece"
#define RMAP_FILETYPE_MAP   "raymap map"
#define RMAP_FORMAT_MAJOR   1
#define RMAP_FORMAT_MINOR   0

/* Rows of a stored chunk, in every column. */
#define RMAP_CHUNK_ROWS 65536

/* Pieces that the view of all pieces as one (virtual datasets) is made for. */
#define RMAP_VIEW_PIECES_MAX 256

/* Where a chunk's bytes lie, so that a reader needs no HDF5 for them. */
struct rmap_chunk_entry {
    uint64_t offset;      /* in the file */
    uint64_t checksum;    /* rmap_checksum of the stored bytes */
    uint32_t nbytes;      /* stored */
    uint32_t index;       /* rows [index x RMAP_CHUNK_ROWS, ...) */
    uint32_t lead_nbytes; /* struct rmap_stream_size */
    uint16_t lead_planes;
    uint16_t column; /* row of /chunk/name */
};

struct rmap_field_table {
    const struct rmap_h5_field *field;
    size_t n;
};

/* Fields of struct rmap_chunk_entry, rmap_portion_info (in a piece, in the index), and
 * rmap_piece_info. */
struct rmap_field_table rmap_chunk_fields(void);
struct rmap_field_table rmap_portion_fields_piece(void);
struct rmap_field_table rmap_portion_fields_index(void);
struct rmap_field_table rmap_piece_fields(void);

/* Dataset of a column: colour has one per colour space. */
const char *rmap_column_path(enum rmap_column column, enum rmap_colour_mode mode);

extern const char *const rmap_table_path[RMAP_TABLE_COUNT]; /* "/ray" ... */

/* Makes piece->name of its shard and number, both in [0, 99999]. */
void rmap_piece_name_set(struct rmap_piece_info *piece);

/* Numbers in a row of a column. */
size_t rmap_column_width(enum rmap_column column, int n_channel);

#endif
