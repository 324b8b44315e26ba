/* SPDX-License-Identifier: MIT */
#include "io/map/chunk_cycle.h"

#include <string.h>

#include "base/alloc.h"

bool rmap_cycle_is(const struct rmap_cycle *a, const struct rmap_cycle *b)
{
    return a->element == b->element && a->n == b->n && a->phase == b->phase;
}

struct rmap_cycle_chunk *rmap_cycle_chunks_find(struct rmap_cycle_chunks *chunks,
                                                const uint8_t *stored, size_t nbytes, size_t n_row,
                                                const struct rmap_cycle *cycle)
{
    const size_t n = chunks->n < RMAP_CYCLES_KNOWN ? chunks->n : RMAP_CYCLES_KNOWN;
    for (size_t k = 0; k < n; k++) {
        struct rmap_cycle_chunk *chunk = &chunks->chunk[k];
        if (chunk->nbytes == nbytes && chunk->n_row == n_row &&
            rmap_cycle_is(&chunk->cycle, cycle) && memcmp(chunk->stored, stored, nbytes) == 0)
            return chunk;
    }
    return NULL;
}

struct rmap_cycle_chunk *rmap_cycle_chunks_add(struct rmap_cycle_chunks *chunks,
                                               const uint8_t *stored, size_t nbytes, size_t n_row,
                                               const struct rmap_cycle *cycle)
{
    struct rmap_cycle_chunk *chunk = &chunks->chunk[chunks->n++ % RMAP_CYCLES_KNOWN];
    memcpy(chunk->stored, stored, nbytes);
    chunk->nbytes = nbytes;
    chunk->n_row = n_row;
    chunk->cycle = *cycle;
    chunk->follows = false;
    return chunk;
}

/* Byte `b` of the elements, n rows of it. Returns whether any is not 0. */
static bool lay_plane(const struct rmap_cycle *cycle, size_t element_nbytes, size_t b, size_t n,
                      uint8_t *to)
{
    const uint8_t *element = cycle->element;
    size_t at = cycle->n < n ? cycle->n : n;
    uint8_t any = 0;
    for (size_t i = 0, k = cycle->phase; i < at; i++) {
        to[i] = element[k * element_nbytes + b];
        any |= to[i];
        k = k + 1 < cycle->n ? k + 1 : 0;
    }
    for (size_t some; at < n; at += some) { /* whole cycles, twice as many each time */
        some = n - at < at ? n - at : at;
        memcpy(to + at, to, some);
    }
    return any != 0;
}

enum rmap_status rmap_cycle_compare(const struct rmap_cycle *cycle, size_t element_nbytes,
                                    const uint8_t *plane, size_t stride, size_t n_lead,
                                    size_t n_row, bool *follows_ret, struct rmap_error *err)
{
    uint8_t *laid = rmap_alloc_unset(n_row, 1);
    bool follows = true;
    if (!laid)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rows", n_row);
    for (size_t b = 0; b < element_nbytes && follows; b++) {
        const bool any = lay_plane(cycle, element_nbytes, b, n_row, laid);
        follows = b < n_lead ? memcmp(laid, plane + b * stride, n_row) == 0 : !any;
    }
    rmap_free(laid);
    *follows_ret = follows;
    return RMAP_OK;
}
