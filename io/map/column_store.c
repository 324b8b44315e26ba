/* SPDX-License-Identifier: MIT
 *
 * Rows of a map's portions that stay in memory for later questions, as many as fit in a budget:
 * those that were asked for first.
 */
#include "io/map/column_store.h"

#include <stdatomic.h>
#include <stdint.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map/arena.h"

struct rmap_column_store {
    _Atomic(void *) *rows; /* [n_portion][RMAP_STORE_SLOTS] */
    size_t n_portion;
    struct rmap_arena *arena;
    _Atomic size_t nbytes[2]; /* of columns, of streams */
};

enum rmap_status rmap_column_store_create(size_t n_portion, size_t budget_nbytes,
                                          struct rmap_column_store **store_ret,
                                          struct rmap_error *err)
{
    struct rmap_column_store *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->n_portion = n_portion;
        if (n_portion <= SIZE_MAX / RMAP_STORE_SLOTS)
            self->rows = rmap_alloc(n_portion * RMAP_STORE_SLOTS, sizeof *self->rows);
    }
    enum rmap_status st =
        self && self->rows ? rmap_arena_create(budget_nbytes, &self->arena, err)
                           : rmap_error_set(err, RMAP_SYSTEM,
                                            "out of memory for a store of %zu portions", n_portion);
    if (st != RMAP_OK) {
        rmap_column_store_destroy(self);
        return st;
    }
    for (size_t i = 0; i < n_portion * RMAP_STORE_SLOTS; i++)
        atomic_init(&self->rows[i], NULL);
    *store_ret = self;
    return RMAP_OK;
}

void rmap_column_store_destroy(struct rmap_column_store *self)
{
    if (!self)
        return;
    rmap_arena_destroy(self->arena);
    rmap_free(self->rows);
    rmap_free(self);
}

void *rmap_column_store_get(const struct rmap_column_store *self, size_t portion, int slot)
{
    return atomic_load_explicit(&self->rows[portion * RMAP_STORE_SLOTS + (size_t)slot],
                                memory_order_acquire);
}

void rmap_column_store_offer(struct rmap_column_store *self, size_t portion, int slot,
                             const void *rows, size_t nbytes)
{
    _Atomic(void *) *its = &self->rows[portion * RMAP_STORE_SLOTS + (size_t)slot];
    void *none = NULL;
    if (atomic_load_explicit(its, memory_order_relaxed))
        return;
    void *copy = rmap_arena_room(self->arena, nbytes > 0 ? nbytes : 1);
    if (!copy)
        return; /* it is decoded again, then */
    if (nbytes > 0)
        memcpy(copy, rows, nbytes);
    if (atomic_compare_exchange_strong_explicit(its, &none, copy, memory_order_release,
                                                memory_order_relaxed))
        atomic_fetch_add(&self->nbytes[slot >= RMAP_STORE_STREAM], nbytes);
}

size_t rmap_column_store_budget(const struct rmap_column_store *self)
{
    return rmap_arena_limit(self->arena);
}

size_t rmap_column_store_taken(const struct rmap_column_store *self)
{
    return rmap_arena_nbytes(self->arena);
}

size_t rmap_column_store_nbytes(const struct rmap_column_store *self, bool of_streams)
{
    return atomic_load(&self->nbytes[of_streams]);
}
