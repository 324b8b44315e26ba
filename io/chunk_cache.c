/* SPDX-License-Identifier: MIT */
#include "io/chunk_cache.h"

#include <stdbool.h>

#include "base/alloc.h"

#define EVICTED_MAX 16 /* chunks remembered after they were let go */

/* Chunks at most: as many as these bytes hold, but never fewer. */
#define BUDGET_NBYTES ((size_t)64 << 20)
#define SLOT_MAX_LOW  64
#define SLOT_MAX_HIGH 1024

struct key {
    size_t piece;
    uint64_t index;
};

struct slot {
    bool used;
    struct key key;
    uint64_t tick; /* of its last use */
    uint8_t *plane;
};

struct rmap_chunk_cache {
    size_t plane_nbytes;
    size_t n_slot, max_slot;         /* in use; most */
    struct slot *slot;               /* [max_slot] */
    struct key evicted[EVICTED_MAX]; /* a ring */
    size_t n_evicted;                /* ever */
    uint64_t tick;
    struct slot *room; /* handed out, not kept yet */
};

static bool equal(const struct key *key, size_t piece, uint64_t index)
{
    return key->piece == piece && key->index == index;
}

enum rmap_status rmap_chunk_cache_create(size_t plane_nbytes, size_t n_shard,
                                         struct rmap_chunk_cache **cache_ret,
                                         struct rmap_error *err)
{
    struct rmap_chunk_cache *cache = rmap_alloc(1, sizeof *cache);
    if (!cache)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    size_t most = BUDGET_NBYTES / (plane_nbytes + 1);
    cache->plane_nbytes = plane_nbytes;
    cache->max_slot = most < SLOT_MAX_LOW    ? SLOT_MAX_LOW
                      : most < SLOT_MAX_HIGH ? most
                                             : SLOT_MAX_HIGH;
    cache->n_slot = n_shard < 1 ? 1 : n_shard < cache->max_slot ? n_shard : cache->max_slot;
    cache->slot = rmap_alloc(cache->max_slot, sizeof *cache->slot);
    if (!cache->slot) {
        rmap_free(cache);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    }
    *cache_ret = cache;
    return RMAP_OK;
}

void rmap_chunk_cache_destroy(struct rmap_chunk_cache *cache)
{
    if (!cache)
        return;
    for (size_t k = 0; k < cache->n_slot; k++)
        rmap_free(cache->slot[k].plane);
    rmap_free(cache->slot);
    rmap_free(cache);
}

const uint8_t *rmap_chunk_cache_find(struct rmap_chunk_cache *cache, size_t piece, uint64_t index)
{
    for (size_t k = 0; k < cache->n_slot; k++) {
        struct slot *slot = &cache->slot[k];
        if (slot->used && equal(&slot->key, piece, index)) {
            slot->tick = ++cache->tick;
            return slot->plane;
        }
    }
    return NULL;
}

static bool was_let_go(const struct rmap_chunk_cache *cache, size_t piece, uint64_t index)
{
    size_t n = cache->n_evicted < EVICTED_MAX ? cache->n_evicted : EVICTED_MAX;
    for (size_t k = 0; k < n; k++)
        if (equal(&cache->evicted[k], piece, index))
            return true;
    return false;
}

enum rmap_status rmap_chunk_cache_room(struct rmap_chunk_cache *cache, size_t piece, uint64_t index,
                                       uint8_t **plane_ret, struct rmap_error *err)
{
    if (cache->n_slot < cache->max_slot && was_let_go(cache, piece, index))
        cache->n_slot++;
    struct slot *room = &cache->slot[0];
    for (size_t k = 1; k < cache->n_slot; k++)
        if (cache->slot[k].tick < room->tick)
            room = &cache->slot[k];
    if (room->used)
        cache->evicted[cache->n_evicted++ % EVICTED_MAX] = room->key;
    room->used = false;
    if (!room->plane)
        room->plane = rmap_alloc(cache->plane_nbytes, 1);
    if (!room->plane)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoded chunk");
    cache->room = room;
    *plane_ret = room->plane;
    return RMAP_OK;
}

void rmap_chunk_cache_keep(struct rmap_chunk_cache *cache, size_t piece, uint64_t index)
{
    cache->room->used = true;
    cache->room->key = (struct key){piece, index};
    cache->room->tick = ++cache->tick;
}
