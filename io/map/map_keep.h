/* SPDX-License-Identifier: MIT
 *
 * What of an open map stays in memory from one question to the next: decoded columns, and what
 * compact pieces store of paths.
 */
#ifndef RMAP_MAP_KEEP_H
#define RMAP_MAP_KEEP_H

#include "io/map/map_reader.h"

/* From now on columns that cursors decode, and the paths of rays, stay in memory until close, and
 * are taken from there: in all so many bytes at most. What does not fit, or has no memory, is read
 * again. Not while a cursor is in use. RMAP_SYSTEM; RMAP_USAGE when called again. */
enum rmap_status rmap_map_keep(struct rmap_map *map, size_t budget_nbytes,
                               struct rmap_error *err) RMAP_MUST_USE;

/* Bytes: what may be kept, what is set aside for it, and what columns and paths take of that. */
struct rmap_map_kept {
    size_t budget, taken, columns, paths;
};
void rmap_map_kept(const struct rmap_map *map, struct rmap_map_kept *kept);

/* Points rows at those of these columns of a portion that are kept, which it returns: nobody writes
 * to them. And keeps a copy of those in rows, all of which are there, as far as there is room. Both
 * thread-safe. */
rmap_column_set rmap_map_borrow_columns(const struct rmap_map *map, size_t portion,
                                        rmap_column_set columns, struct rmap_portion *rows);
void rmap_map_keep_columns(const struct rmap_map *map, size_t portion, rmap_column_set columns,
                           const struct rmap_portion *rows);

/* The same of a stream of a portion of a compact piece, one that tells of paths: its rows, or NULL.
 */
void *rmap_map_borrow_stream(const struct rmap_map *map, size_t portion, int stream);
void rmap_map_keep_stream(const struct rmap_map *map, size_t portion, int stream, const void *rows,
                          size_t nbytes);

#endif
