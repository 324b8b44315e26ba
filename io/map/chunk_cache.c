/* SPDX-License-Identifier: MIT
 *
 * The inflated chunks that a cursor keeps of one column.
 */
#include "io/map/chunk_cache.h"

#include <stdbool.h>

#include "base/alloc.h"

#define EVICTED_MAX 16 /* chunks remembered after they were let go */

/* Chunks of a cache at most; it keeps as many as the least. */
#define SLOT_MAX 1024
#define SLOT_MIN 2

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
    struct rmap_chunk_budget *budget;
    struct rmap_chunk_cache *next;   /* of the budget */
    size_t plane_nbytes, n_plane;    /* of a chunk; chunks in memory */
    size_t n_slot, max_slot;         /* in use; most */
    struct slot *slot;               /* [max_slot] */
    struct key evicted[EVICTED_MAX]; /* a ring */
    size_t n_evicted;                /* ever */
    struct slot *room;               /* handed out, not kept yet */
};

static bool equal(const struct key *key, size_t piece, uint64_t index)
{
    return key->piece == piece && key->index == index;
}

enum rmap_status rmap_chunk_cache_create(struct rmap_chunk_budget *budget, size_t plane_nbytes,
                                         size_t n_shard, struct rmap_chunk_cache **cache_ret,
                                         struct rmap_error *err)
{
    struct rmap_chunk_cache *cache = rmap_alloc(1, sizeof *cache);
    if (!cache)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    size_t most = budget->limit_nbytes / (plane_nbytes + 1);
    cache->budget = budget;
    cache->plane_nbytes = plane_nbytes;
    cache->max_slot = most < SLOT_MIN ? SLOT_MIN : most < SLOT_MAX ? most : SLOT_MAX;
    cache->n_slot = n_shard < 1 ? 1 : n_shard < cache->max_slot ? n_shard : cache->max_slot;
    cache->slot = rmap_alloc(cache->max_slot, sizeof *cache->slot);
    if (!cache->slot) {
        rmap_free(cache);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    }
    cache->next = budget->first;
    budget->first = cache;
    *cache_ret = cache;
    return RMAP_OK;
}

void rmap_chunk_cache_destroy(struct rmap_chunk_cache *cache)
{
    if (!cache)
        return;
    struct rmap_chunk_cache **at = &cache->budget->first;
    while (*at != cache)
        at = &(*at)->next;
    *at = cache->next;
    cache->budget->nbytes -= cache->n_plane * cache->plane_nbytes;
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
            slot->tick = ++cache->budget->tick;
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

static void let_go(struct rmap_chunk_cache *cache, struct slot *slot)
{
    if (slot->used)
        cache->evicted[cache->n_evicted++ % EVICTED_MAX] = slot->key;
    slot->used = false;
    slot->tick = 0;
}

/* The least recently used chunk in memory of one cache; NULL: none. */
static struct slot *oldest_of(struct rmap_chunk_cache *cache)
{
    struct slot *oldest = NULL;
    for (size_t k = 0; k < cache->n_slot; k++)
        if (cache->slot[k].plane && (!oldest || cache->slot[k].tick < oldest->tick))
            oldest = &cache->slot[k];
    return oldest;
}

/* Frees the chunk not used for longest of the caches with more than `least`; false: none has. */
static bool free_one(struct rmap_chunk_budget *budget, size_t least)
{
    struct rmap_chunk_cache *owner = NULL;
    struct slot *oldest = NULL;
    for (struct rmap_chunk_cache *other = budget->first; other; other = other->next) {
        struct slot *slot = other->n_plane > least ? oldest_of(other) : NULL;
        if (slot && (!oldest || slot->tick < oldest->tick)) {
            oldest = slot;
            owner = other;
        }
    }
    if (!oldest)
        return false;
    let_go(owner, oldest);
    rmap_free(oldest->plane);
    oldest->plane = NULL;
    owner->n_plane--;
    budget->nbytes -= owner->plane_nbytes;
    return true;
}

/* Frees chunks until one more of this cache fits: first of caches with more than they should keep.
 */
static void make_room(struct rmap_chunk_cache *cache)
{
    struct rmap_chunk_budget *budget = cache->budget;
    while (budget->nbytes + cache->plane_nbytes > budget->limit_nbytes)
        if (!free_one(budget, SLOT_MIN) && !free_one(budget, 0))
            return;
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
    if (!room->plane)
        make_room(cache);
    let_go(cache, room);
    if (!room->plane) {
        room->plane = rmap_alloc_unset(cache->plane_nbytes, 1);
        if (!room->plane)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoded chunk");
        cache->n_plane++;
        cache->budget->nbytes += cache->plane_nbytes;
    }
    cache->room = room;
    *plane_ret = room->plane;
    return RMAP_OK;
}

void rmap_chunk_cache_keep(struct rmap_chunk_cache *cache, size_t piece, uint64_t index)
{
    cache->room->used = true;
    cache->room->key = (struct key){piece, index};
    cache->room->tick = ++cache->budget->tick;
}
