/* SPDX-License-Identifier: MIT
 *
 * Writes columns of a piece beside it (io/map/piece_columns.h). One thread.
 */
#ifndef RMAP_COLUMNS_WRITER_H
#define RMAP_COLUMNS_WRITER_H

#include "io/map/piece_columns.h"

struct rmap_columns_writer;

/* columns: of rmap_keepable_columns. The map is borrowed. */
enum rmap_status rmap_columns_writer_create(const struct rmap_map *map, size_t piece,
                                            rmap_column_set columns,
                                            struct rmap_columns_writer **writer_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* The rows of a portion, behind those put before; every portion of the piece in the map's order. */
enum rmap_status rmap_columns_writer_put(struct rmap_columns_writer *writer,
                                         const struct rmap_portion *rows,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Gives the file its name, in place of what has it; durable when it returns. */
enum rmap_status rmap_columns_writer_finish(struct rmap_columns_writer *writer,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Releases; what was not finished is removed. NULL is fine. */
void rmap_columns_writer_destroy(struct rmap_columns_writer *writer);

#endif
