/* SPDX-License-Identifier: MIT
 *
 * A shard's buffers under one lock; encoding outside any lock; HDF5 in one thread.
 *
 * A full buffer goes to a queue that keeps the order of filling, so the file does not
 * depend on which thread encoded what. A piece ends between two portions: its buffers are flushed
 * as they are, and a sign in the queue tells the writing thread to close it. A flush is such a sign
 * too: when it comes out, all that was appended before it is stored or in the sign's batch.
 */
#ifndef RMAP_SHARD_WRITER_H
#define RMAP_SHARD_WRITER_H

#include "io/map/map_writer.h"

/* directory: the map's, or another that exists, say on a disk of the node; shard-RRRRR is made in
 * it. options: NULL for 512 MiB and RMAP_FLUSH_SECONDS. run is copied, what it points to borrowed.
 */
enum rmap_status rmap_shard_writer_create(const char *directory, int shard,
                                          const struct rmap_run *run,
                                          const struct rmap_shard_options *options,
                                          struct rmap_shard_writer **writer_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Encodes one full chunk if there is one; *did_ret says whether. Thread-safe; any thread. */
enum rmap_status rmap_shard_writer_encode(struct rmap_shard_writer *writer, bool *did_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Stores the chunks encoded so far, and flushes when it is time. The writing thread alone. */
enum rmap_status rmap_shard_writer_store(struct rmap_shard_writer *writer,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Bytes waiting to be encoded or stored: workers help out rather than run ahead. Any thread. */
size_t rmap_shard_writer_backlog(const struct rmap_shard_writer *writer);

/* Makes safe all that was appended before the call, helping to encode and waiting for the threads
 * that do. The writing thread alone. */
enum rmap_status rmap_shard_writer_flush(struct rmap_shard_writer *writer,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Nothing more will be appended: buffers are handed over as they are, for any thread to encode.
 * One thread, after the last append; nothing to do is fine. */
enum rmap_status rmap_shard_writer_end(struct rmap_shard_writer *writer,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Flushes, publishes the last piece, and closes. The writing thread, after all others are done. */
enum rmap_status rmap_shard_writer_finish(struct rmap_shard_writer *writer,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* How often it was flushed. The writing thread alone. */
uint64_t rmap_shard_writer_flushes(const struct rmap_shard_writer *writer);

/* The pieces published so far, for the index; borrowed. The writing thread alone. */
const struct rmap_map_content *rmap_shard_writer_content(const struct rmap_shard_writer *writer);

/* Drops what is unfinished and was never flushed; what was flushed stays for the map's reader. */
void rmap_shard_writer_destroy(struct rmap_shard_writer *writer);

#endif
