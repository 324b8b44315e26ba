/* SPDX-License-Identifier: MIT
 *
 * Columns of a compact piece that stand beside it as they are (`raymap keep`), so that its rays
 * need not be traced again for them: shard-RRRRR/piece-KKKKK.columns.h5. docs/map.md has its
 * datasets.
 */
#ifndef RMAP_PIECE_COLUMNS_H
#define RMAP_PIECE_COLUMNS_H

#include "io/map/map_internal.h"

#define RMAP_FILETYPE_COLUMNS "raymap columns"
#define RMAP_COLUMNS_SUFFIX   ".columns.h5" /* in place of ".h5" of its piece */

/* Those that may stand there: what rays are traced again for. */
rmap_column_set rmap_keepable_columns(void);

/* "MAP/shard-00000/piece-00000.columns.h5"; rmap_free. NULL when memory is short. */
char *rmap_piece_columns_path(const char *map_path, const struct rmap_piece_info *piece);

/* What a piece's rays are: the sum of the digests of its portions. Borrowed from the map, which
 * sums up all pieces once; NULL: memory is short. Thread-safe. */
const struct rmap_digest *rmap_map_piece_digest(const struct rmap_map *map, size_t piece);

/* What such a file holds; opened while the map is. */
struct rmap_piece_columns {
    rmap_column_set columns;
    struct rmap_piece_chunks chunks; /* of stream c, the column */
    struct rmap_chunk_entry *entry;  /* [n_entry] of these */
    size_t n_entry;
    uint64_t nbytes; /* of the file */
};

/* Columns beside a piece; 0: there are none, or of other rays, or they are damaged, which reading
 * them says. Thread-safe. */
rmap_column_set rmap_map_columns_beside(const struct rmap_map *map, size_t piece);

/* *columns_ret: borrowed from the map; NULL: none. RMAP_FORMAT names the file and the remedy. */
enum rmap_status rmap_map_piece_columns(const struct rmap_map *map, size_t piece,
                                        const struct rmap_piece_columns **columns_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* [RMAP_TABLE_COUNT] where the portion's rows begin in the columns of its piece that stand there:
 * portions follow each other as in the map. Once the map has columns beside a piece. */
const uint64_t *rmap_map_first_rows(const struct rmap_map *map, size_t portion);

/* Reads one, whether the map knows of it or not. RMAP_INPUT: there is none; RMAP_FORMAT: damaged,
 * or of other rays, which *is_stale_ret tells apart. columns: rmap_piece_columns_fini. */
enum rmap_status rmap_piece_columns_read(const struct rmap_map *map, size_t piece,
                                         struct rmap_piece_columns *columns, bool *is_stale_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_piece_columns_fini(struct rmap_piece_columns *columns);

/* What a map has of them. Opens every one. */
struct rmap_columns_survey {
    size_t n_piece; /* that have some, of the map's n_compact that may */
    size_t n_compact;
    rmap_column_set columns; /* that all of these n_piece have */
    uint64_t nbytes;         /* of these files */
    size_t n_unused;         /* others: of other rays, or damaged */
    struct rmap_error why;   /* of the first of these */
};
enum rmap_status rmap_map_columns_survey(const struct rmap_map *map,
                                         struct rmap_columns_survey *survey,
                                         struct rmap_error *err) RMAP_MUST_USE;

void rmap_column_files_destroy(struct rmap_column_files *files); /* NULL is fine */

#endif
