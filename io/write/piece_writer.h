/* SPDX-License-Identifier: MIT
 *
 * One piece of a shard: a complete HDF5 file that takes ready chunks and is published at the end.
 */
#ifndef RMAP_PIECE_WRITER_H
#define RMAP_PIECE_WRITER_H

#include "compact/path_sum.h"
#include "io/codec/codec.h"
#include "io/map/map_content.h"
#include "io/map/map_writer.h"
#include "io/write/journal_writer.h"

struct rmap_piece_writer;

/* run is borrowed; origin: rmap_piece_origin_of(run). */
enum rmap_status rmap_piece_writer_create(const char *shard_path, int shard, int number,
                                          const struct rmap_run *run,
                                          const struct rmap_piece_origin *origin,
                                          struct rmap_piece_writer **writer_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Stores chunk `index` of a stream, after which the stream has n_row rows. */
enum rmap_status rmap_piece_writer_put(struct rmap_piece_writer *writer, int stream, uint32_t index,
                                       uint64_t n_row, const uint8_t *stored, size_t nbytes,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Makes what was put so far safe, with the batch's tails and portions: after it the piece commits
 * stored_rows rows per table and n_portion portions, whatever happens to this process. The batch
 * is empty then. On failure earlier commits hold, and the piece takes nothing more. */
enum rmap_status rmap_piece_writer_flush(struct rmap_piece_writer *writer,
                                         struct rmap_journal_batch *batch,
                                         const uint64_t *stored_rows, uint64_t n_portion,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Writes the tables of chunks and portions, closes and publishes, under the next free number if
 * its own was taken meanwhile; then appends the piece to `content`. stored_rows:
 * [RMAP_STORED_TABLE_MAX], rows of each stored table. path: [rows of /path] of a compact one,
 * or NULL: not known. */
enum rmap_status rmap_piece_writer_finish(struct rmap_piece_writer *writer,
                                          const struct rmap_portion_info *portion, size_t n_portion,
                                          const uint64_t *stored_rows,
                                          const struct rmap_path_sum *path,
                                          struct rmap_map_content *content,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Releases. What was not finished is removed, unless it was flushed: then file and journal stay,
 * for they hold rays. NULL is fine. */
void rmap_piece_writer_destroy(struct rmap_piece_writer *writer);

#endif
