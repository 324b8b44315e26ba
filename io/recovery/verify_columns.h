/* SPDX-License-Identifier: MIT
 *
 * Whether columns that are kept beside pieces are sound, and those that the pieces decode to.
 */
#ifndef RMAP_VERIFY_COLUMNS_H
#define RMAP_VERIFY_COLUMNS_H

#include "io/recovery/verify.h"

struct rmap_cursor;

/* The file beside a piece, if there is one. Uses HDF5. */
enum rmap_status rmap_verify_columns_file(struct rmap_verification *self, size_t piece,
                                          struct rmap_findings *findings,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* What it has of a portion that the cursor has just read, all columns of it. Any thread. */
enum rmap_status rmap_verify_columns(struct rmap_verification *self, struct rmap_cursor *cursor,
                                     size_t portion, struct rmap_findings *findings,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Files beside no piece: piece [n_piece], by shard and number, are all on disk. */
enum rmap_status rmap_verify_stray_columns(struct rmap_verification *self,
                                           const struct rmap_piece_name *piece, size_t n_piece,
                                           struct rmap_findings *findings,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Removes files that are damaged, of other rays, or beside no piece of the map. */
enum rmap_status rmap_remove_bad_columns(const struct rmap_map *map, struct rmap_findings *done,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
