/* SPDX-License-Identifier: MIT
 *
 * Many small pieces of memory that are given back together. Zero-initialise; a copy of the struct
 * takes the memory over.
 */
#ifndef RMAP_POOL_H
#define RMAP_POOL_H

#include <stddef.h>

struct rmap_pool {
    void *block; /* the last one, which begins with the address of the one before it */
    char *at;    /* in it */
    size_t left, block_nbytes;
};

/* Memory for n elements of size bytes, aligned for pointers and numbers, until rmap_pool_fini; what
 * it holds is undefined. NULL when it cannot be had. */
void *rmap_pool_alloc(struct rmap_pool *pool, size_t n, size_t size);
char *rmap_pool_strdup(struct rmap_pool *pool,
                       const char *text); /* NULL: so is text, or the same */

void rmap_pool_fini(struct rmap_pool *pool);

#endif
