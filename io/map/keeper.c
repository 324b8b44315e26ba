/* SPDX-License-Identifier: MIT
 *
 * Memory for what stays of an open map between questions: many blocks of some kilobytes that all
 * go at once, within a budget of bytes.
 */
#include "io/map/keeper.h"

#include <pthread.h>
#include <stdint.h>

#include "base/alloc.h"

enum { ALIGN = 64, SLAB_MAX = 4 << 20, SLABS_MIN = 64 };

struct slab {
    struct slab *next;
};

struct rmap_keeper {
    pthread_mutex_t lock;
    size_t limit, slab_nbytes, nbytes; /* nbytes: of slabs, and claimed */
    struct slab *slab;                 /* all of them */
    uint8_t *at;                       /* room in the last one, of `left` bytes */
    size_t left;
};

enum rmap_status rmap_keeper_create(size_t limit_nbytes, struct rmap_keeper **keeper_ret,
                                    struct rmap_error *err)
{
    struct rmap_keeper *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for what is kept of a map");
    (void)pthread_mutex_init(&self->lock, NULL);
    self->limit = limit_nbytes;
    self->slab_nbytes = limit_nbytes / SLABS_MIN < SLAB_MAX ? limit_nbytes / SLABS_MIN : SLAB_MAX;
    *keeper_ret = self;
    return RMAP_OK;
}

void rmap_keeper_destroy(struct rmap_keeper *self)
{
    if (!self)
        return;
    for (struct slab *slab = self->slab, *next; slab; slab = next) {
        next = slab->next;
        rmap_free(slab);
    }
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self);
}

static bool claim(struct rmap_keeper *self, size_t nbytes)
{
    if (nbytes > self->limit - self->nbytes)
        return false;
    self->nbytes += nbytes;
    return true;
}

/* A slab for blocks, or one for a block that is as large as some slabs. */
static uint8_t *add_slab(struct rmap_keeper *self, size_t nbytes)
{
    if (!claim(self, nbytes))
        return NULL;
    struct slab *slab = rmap_alloc_unset(nbytes, 1);
    if (!slab) {
        self->nbytes -= nbytes;
        return NULL;
    }
    slab->next = self->slab;
    self->slab = slab;
    return (uint8_t *)slab;
}

/* From the first multiple of ALIGN behind the slab's own on. */
static uint8_t *begin_of(uint8_t *slab)
{
    const uintptr_t at = (uintptr_t)slab + sizeof(struct slab);
    return slab + ((at + ALIGN - 1) / ALIGN * ALIGN - (uintptr_t)slab);
}

static void *find_room(struct rmap_keeper *self, size_t nbytes)
{
    const size_t own = sizeof(struct slab) + ALIGN;
    if (nbytes > self->left) {
        const bool is_large = nbytes > self->slab_nbytes / 4;
        const size_t slab_nbytes = is_large ? nbytes + own : self->slab_nbytes;
        uint8_t *slab = add_slab(self, slab_nbytes);
        if (!slab || is_large)
            return slab ? begin_of(slab) : NULL;
        self->at = begin_of(slab);
        self->left = (size_t)(slab + slab_nbytes - self->at);
    }
    void *room = self->at;
    self->at += nbytes;
    self->left -= nbytes;
    return room;
}

void *rmap_keeper_room(struct rmap_keeper *self, size_t nbytes)
{
    if (nbytes > SIZE_MAX / 2)
        return NULL;
    (void)pthread_mutex_lock(&self->lock);
    void *room = find_room(self, (nbytes + ALIGN - 1) / ALIGN * ALIGN);
    (void)pthread_mutex_unlock(&self->lock);
    return room;
}

bool rmap_keeper_claim(struct rmap_keeper *self, size_t nbytes)
{
    (void)pthread_mutex_lock(&self->lock);
    bool is = claim(self, nbytes);
    (void)pthread_mutex_unlock(&self->lock);
    return is;
}

size_t rmap_keeper_limit(const struct rmap_keeper *self)
{
    return self->limit;
}

size_t rmap_keeper_nbytes(const struct rmap_keeper *self)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)(uintptr_t)&self->lock;
    (void)pthread_mutex_lock(lock);
    size_t nbytes = self->nbytes;
    (void)pthread_mutex_unlock(lock);
    return nbytes;
}
