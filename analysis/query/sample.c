/* SPDX-License-Identifier: MIT
 *
 * The N of many rays that have the smallest keys, whatever order they come in: with a hash as the
 * key a random sample that anybody finds again, with the id itself the first N rays.
 */
#include "analysis/query/sample.h"

#include <stdlib.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"

uint64_t rmap_sample_key(uint64_t seed, uint64_t id)
{
    uint8_t bytes[16];
    for (int i = 0; i < 8; i++) {
        bytes[i] = (uint8_t)(seed >> 8 * i);
        bytes[8 + i] = (uint8_t)(id >> 8 * i);
    }
    return XXH3_64bits(bytes, sizeof bytes);
}

static bool less(struct rmap_sample_ray a, struct rmap_sample_ray b)
{
    return a.key < b.key || (a.key == b.key && a.id < b.id);
}

bool rmap_sample_wants(const struct rmap_sample *sample, struct rmap_sample_ray ray)
{
    return sample->n < sample->most || less(ray, sample->ray[0]);
}

static void swap(struct rmap_sample_ray *a, struct rmap_sample_ray *b)
{
    struct rmap_sample_ray kept = *a;
    *a = *b;
    *b = kept;
}

static void rise(struct rmap_sample_ray *heap, size_t at)
{
    for (; at > 0 && less(heap[(at - 1) / 2], heap[at]); at = (at - 1) / 2)
        swap(&heap[at], &heap[(at - 1) / 2]);
}

static void sink(struct rmap_sample_ray *heap, size_t n)
{
    size_t at = 0;
    for (;;) {
        size_t most = at, left = 2 * at + 1, right = left + 1;
        if (left < n && less(heap[most], heap[left]))
            most = left;
        if (right < n && less(heap[most], heap[right]))
            most = right;
        if (most == at)
            return;
        swap(&heap[at], &heap[most]);
        at = most;
    }
}

enum rmap_status rmap_sample_add(struct rmap_sample *sample, struct rmap_sample_ray ray,
                                 struct rmap_error *err)
{
    if (!rmap_sample_wants(sample, ray))
        return RMAP_OK;
    if (sample->n == sample->most) {
        sample->ray[0] = ray;
        sink(sample->ray, sample->n);
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(sample->ray, sample->cap, sample->n + 1, err);
    if (st != RMAP_OK)
        return st;
    sample->ray[sample->n] = ray;
    rise(sample->ray, sample->n++);
    return RMAP_OK;
}

static int by_id(const void *a, const void *b)
{
    const uint64_t *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

void rmap_sort_ids(uint64_t *id, size_t n)
{
    if (n > 0)
        qsort(id, n, sizeof *id, by_id);
}

enum rmap_status rmap_sample_ids(const struct rmap_sample *sample, uint64_t **id_ret,
                                 struct rmap_error *err)
{
    uint64_t *id = rmap_alloc(sample->n, sizeof *id);
    if (!id)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu ray ids", sample->n);
    for (size_t i = 0; i < sample->n; i++)
        id[i] = sample->ray[i].id;
    rmap_sort_ids(id, sample->n);
    *id_ret = id;
    return RMAP_OK;
}

void rmap_sample_fini(struct rmap_sample *sample)
{
    rmap_free(sample->ray);
    *sample = (struct rmap_sample){.most = sample->most};
}
