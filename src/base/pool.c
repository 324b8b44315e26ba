/* SPDX-License-Identifier: MIT
 *
 * Blocks of memory, dealt out from their beginning.
 */
#include "base/pool.h"

#include <stdalign.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/alloc.h"

enum { ALIGNED = alignof(uint64_t), LEAST = 4 << 10, MOST = 2 << 20 };

/* What is large has a block of its own, behind which dealing goes on. */
static char *new_block(struct rmap_pool *pool, size_t nbytes)
{
    const size_t twice = pool->block_nbytes < LEAST ? LEAST : 2 * pool->block_nbytes,
                 usual = twice < MOST ? twice : MOST;
    const bool own = nbytes > usual / 4;
    char *block =
        nbytes < SIZE_MAX / 2 ? rmap_alloc_unset(1, own ? ALIGNED + nbytes : usual) : NULL;
    if (!block)
        return NULL;
    if (own && pool->block) { /* the one before it stays the last */
        memcpy(block, pool->block, sizeof(void *));
        memcpy(pool->block, &block, sizeof(void *));
        return block + ALIGNED;
    }
    memcpy(block, &pool->block, sizeof(void *));
    pool->block = block;
    pool->at = block + ALIGNED + nbytes;
    pool->left = own ? 0 : usual - ALIGNED - nbytes;
    pool->block_nbytes = own ? 0 : usual;
    return block + ALIGNED;
}

static char *take(struct rmap_pool *pool, size_t nbytes, size_t aligned)
{
    const size_t pad = (aligned - (uintptr_t)pool->at % aligned) % aligned;
    if (pool->left < pad || pool->left - pad < nbytes || !pool->at)
        return new_block(pool, nbytes);
    char *at = pool->at + pad;
    pool->at = at + nbytes;
    pool->left -= pad + nbytes;
    return at;
}

void *rmap_pool_alloc(struct rmap_pool *pool, size_t n, size_t size)
{
    return size && n > SIZE_MAX / size ? NULL : take(pool, n * size, ALIGNED);
}

char *rmap_pool_strdup(struct rmap_pool *pool, const char *text)
{
    const size_t nbytes = text ? strlen(text) + 1 : 0;
    char *copy = text ? take(pool, nbytes, 1) : NULL;
    if (copy)
        memcpy(copy, text, nbytes);
    return copy;
}

void rmap_pool_fini(struct rmap_pool *pool)
{
    for (void *block = pool->block, *before; block; block = before) {
        memcpy(&before, block, sizeof before);
        rmap_free(block);
    }
    *pool = (struct rmap_pool){0};
}
