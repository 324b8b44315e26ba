/* SPDX-License-Identifier: MIT
 *
 * Memory for what stays of an open map between questions: many blocks of some kilobytes that all
 * go at once, within a budget of bytes.
 */
#include "io/map/arena.h"

#include <pthread.h>
#include <stdint.h>

#include "base/alloc.h"

enum { ALIGN = 64 };

/* Before its bytes, which begin at a multiple of ALIGN. */
struct block {
    struct block *next;
};

struct rmap_arena {
    pthread_mutex_t lock;
    size_t limit, nbytes; /* nbytes: of blocks, and claimed */
    struct block *block;  /* all of them */
};

enum rmap_status rmap_arena_create(size_t limit_nbytes, struct rmap_arena **arena_ret,
                                   struct rmap_error *err)
{
    struct rmap_arena *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for what is kept of a map");
    (void)pthread_mutex_init(&self->lock, NULL);
    self->limit = limit_nbytes;
    *arena_ret = self;
    return RMAP_OK;
}

void rmap_arena_destroy(struct rmap_arena *self)
{
    if (!self)
        return;
    for (struct block *block = self->block, *next; block; block = next) {
        next = block->next;
        rmap_free(block);
    }
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self);
}

static bool claim(struct rmap_arena *self, size_t nbytes)
{
    if (nbytes > self->limit - self->nbytes)
        return false;
    self->nbytes += nbytes;
    return true;
}

void *rmap_arena_room(struct rmap_arena *self, size_t nbytes)
{
    const size_t own = sizeof(struct block) + ALIGN;
    struct block *block = NULL;
    if (nbytes > SIZE_MAX / 2)
        return NULL;
    (void)pthread_mutex_lock(&self->lock);
    if (claim(self, nbytes + own)) {
        block = rmap_alloc_unset(nbytes + own, 1);
        if (block) {
            block->next = self->block;
            self->block = block;
        } else {
            self->nbytes -= nbytes + own;
        }
    }
    (void)pthread_mutex_unlock(&self->lock);
    return block ? (uint8_t *)block + own - (uintptr_t)((uint8_t *)block + own) % ALIGN : NULL;
}

size_t rmap_arena_limit(const struct rmap_arena *self)
{
    return self->limit;
}

size_t rmap_arena_nbytes(const struct rmap_arena *self)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)(uintptr_t)&self->lock;
    (void)pthread_mutex_lock(lock);
    size_t nbytes = self->nbytes;
    (void)pthread_mutex_unlock(lock);
    return nbytes;
}
