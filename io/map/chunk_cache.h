/* SPDX-License-Identifier: MIT
 *
 * The inflated chunks that a cursor keeps of one column. It begins with one per shard and grows
 * only when a chunk comes back that it had let go: blocks of several threads stand out of order by
 * some chunks, and nobody knows by how many before reading them. Fresh memory costs page faults.
 * The caches of a cursor share a budget of bytes: beyond it, the chunk that was not used for
 * longest goes, first in caches that have more than two. The one in hand stays.
 */
#ifndef RMAP_CHUNK_CACHE_H
#define RMAP_CHUNK_CACHE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_chunk_cache;

/* Begins as {limit_nbytes}; outlives its caches. */
struct rmap_chunk_budget {
    size_t limit_nbytes, nbytes; /* at most, which may change; in use */
    uint64_t tick;
    struct rmap_chunk_cache *first;
};

/* plane_nbytes: bytes of an inflated chunk; n_shard: in the map. */
enum rmap_status rmap_chunk_cache_create(struct rmap_chunk_budget *budget, size_t plane_nbytes,
                                         size_t n_shard, struct rmap_chunk_cache **cache_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_chunk_cache_destroy(struct rmap_chunk_cache *cache);

/* Chunk `index` of a piece, or NULL when it is not there. */
const uint8_t *rmap_chunk_cache_find(struct rmap_chunk_cache *cache, size_t piece, uint64_t index);

/* Room for that chunk, in place of the least recently used one if need be. It counts as there once
 * it is kept; until then the room is nobody's. */
enum rmap_status rmap_chunk_cache_room(struct rmap_chunk_cache *cache, size_t piece, uint64_t index,
                                       uint8_t **plane_ret, struct rmap_error *err) RMAP_MUST_USE;
void rmap_chunk_cache_keep(struct rmap_chunk_cache *cache, size_t piece, uint64_t index);

#endif
