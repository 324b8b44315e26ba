/* SPDX-License-Identifier: MIT
 *
 * Rows of a map's streams, from stored chunks by pread and our own inflate, or from a journal's
 * tails. Keeps the last inflated chunks of every stream. One thread at a time.
 */
#ifndef RMAP_CHUNK_READER_H
#define RMAP_CHUNK_READER_H

#include "io/map/map_reader.h"

struct rmap_chunk_reader;

enum rmap_status rmap_chunk_reader_create(const struct rmap_map *map,
                                          struct rmap_chunk_reader **reader_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_chunk_reader_destroy(struct rmap_chunk_reader *reader);

/* Rows [first, first + n) of a stream of a piece's layout into `to`, [n][width]; they must lie in
 * the piece. RMAP_FORMAT names the piece, the damaged dataset and the chunk. */
enum rmap_status rmap_chunk_reader_rows(struct rmap_chunk_reader *reader, size_t piece, int stream,
                                        uint64_t first, size_t n, void *to,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The same of a column that stands beside the piece (rmap_map_columns_beside). */
enum rmap_status rmap_chunk_reader_kept(struct rmap_chunk_reader *reader, size_t piece, int column,
                                        uint64_t first, size_t n, void *to,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_cursor_nbytes and rmap_cursor_nbytes_of_rows. */
uint64_t rmap_chunk_reader_nbytes(const struct rmap_chunk_reader *reader);
uint64_t rmap_chunk_reader_nbytes_of_rows(const struct rmap_chunk_reader *reader);
void rmap_chunk_reader_set_nbytes_of_rows(struct rmap_chunk_reader *reader, uint64_t nbytes);

#endif
