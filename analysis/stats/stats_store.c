/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_store.h"

#include <stdint.h>
#include <string.h>

#include "base/alloc.h"

/* A small chunk, then such as huge pages stand behind. */
enum { CHUNK_FIRST = 1 << 16, CHUNK_SECOND = 1 << 21, CHUNK_LAST = 1 << 23, ALIGNMENT = 64 };

void rmap_stats_store_fini(struct rmap_stats_store *store)
{
    for (size_t i = 0; i < store->n_chunk; i++)
        rmap_free(store->chunk[i]);
    rmap_free(store->chunk);
    *store = (struct rmap_stats_store){0};
}

static enum rmap_status add_chunk(struct rmap_stats_store *store, size_t nbytes,
                                  struct rmap_error *err)
{
    void *list = store->chunk;
    enum rmap_status st =
        rmap_reserve(&list, &store->chunk_cap, store->n_chunk + 1, sizeof *store->chunk, err);
    store->chunk = list;
    if (st != RMAP_OK)
        return st;
    size_t size = store->n_chunk == 0   ? CHUNK_FIRST
                  : store->n_chunk == 1 ? CHUNK_SECOND
                                        : 2 * store->size;
    size = size < CHUNK_LAST ? size : CHUNK_LAST;
    size = size > nbytes ? size : nbytes;
    void *chunk = rmap_alloc_unset(size, 1);
    if (!chunk)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu bytes of readings", size);
    store->chunk[store->n_chunk++] = chunk;
    store->size = size;
    store->used = 0;
    return RMAP_OK;
}

enum rmap_status rmap_stats_store_take(struct rmap_stats_store *store, size_t n, size_t size,
                                       void **piece_ret, struct rmap_error *err)
{
    *piece_ret = NULL;
    if (n > (SIZE_MAX / 2 - ALIGNMENT) / size)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu readings", n);
    const size_t nbytes = (n * size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (nbytes > store->size - store->used) {
        enum rmap_status st = add_chunk(store, nbytes, err);
        if (st != RMAP_OK)
            return st;
    }
    *piece_ret = (uint8_t *)store->chunk[store->n_chunk - 1] + store->used;
    store->used += nbytes;
    return RMAP_OK;
}

void rmap_stats_store_give_back(struct rmap_stats_store *store,
                                const struct rmap_stats_store *before)
{
    store->used = store->n_chunk == before->n_chunk ? before->used : 0;
}

enum rmap_status rmap_stats_store_absorb(struct rmap_stats_store *store,
                                         struct rmap_stats_store *from, struct rmap_error *err)
{
    const size_t n = store->n_chunk + from->n_chunk;
    void *list = store->chunk;
    if (from->n_chunk == 0)
        return RMAP_OK;
    enum rmap_status st = rmap_reserve(&list, &store->chunk_cap, n, sizeof *store->chunk, err);
    store->chunk = list;
    if (st != RMAP_OK)
        return st;
    memcpy(store->chunk + store->n_chunk, from->chunk, from->n_chunk * sizeof *store->chunk);
    store->n_chunk = n;
    store->used = from->used; /* of the last one */
    store->size = from->size;
    from->n_chunk = 0;
    rmap_stats_store_fini(from);
    return RMAP_OK;
}
