/* SPDX-License-Identifier: MIT
 *
 * Traced blocks on their way into a shard's buffers.
 */
#ifndef RMAP_SHARD_APPEND_H
#define RMAP_SHARD_APPEND_H

#include "io/map/map_writer.h"

/* Copies a block's rows to the shard's column buffers. Thread-safe; any thread. */
enum rmap_status rmap_shard_writer_append(struct rmap_shard_writer *writer,
                                          const struct rmap_portion *portion,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* A block that is appended in parts of up to RMAP_PART_RAYS rays, which need not stay: each is
 * taken while it is in a cache. One per thread; the writer is borrowed. NULL: this shard takes
 * whole blocks alone. RMAP_SYSTEM: memory. */
struct rmap_shard_block;
enum rmap_status rmap_shard_block_create(struct rmap_shard_writer *writer,
                                         struct rmap_shard_block **block_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_shard_block_destroy(struct rmap_shard_block *block);

/* In the order of the ids, which are consecutive. *whole_ret: nothing of the block has been
 * appended, and it must be by rmap_shard_writer_append. The block is empty then, and on failure. */
enum rmap_status rmap_shard_block_add(struct rmap_shard_block *block,
                                      const struct rmap_portion *part, bool *whole_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Appends the parts added so far as one portion, if any were; the block is empty then. */
enum rmap_status rmap_shard_block_append(struct rmap_shard_block *block, bool *whole_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
