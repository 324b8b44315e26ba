/* SPDX-License-Identifier: MIT
 *
 * Memory through one door: overflow-checked, countable by tests, failable by tests.
 */
#define _DEFAULT_SOURCE /* madvise */
#include "base/alloc.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Counters of the test hooks only; no behaviour rests on them outside tests. */
static _Atomic int64_t live_count;
static _Atomic int64_t fail_countdown;

static int must_fail(void)
{
    if (atomic_load_explicit(&fail_countdown, memory_order_relaxed) == 0)
        return 0;
    return atomic_fetch_sub(&fail_countdown, 1) == 1;
}

/* Large blocks are read here and there: with huge pages, their addresses are found at once, and one
 * fault brings what else are 512. */
#define HUGE_PAGE ((uintptr_t)2 << 20)

#ifdef MADV_HUGEPAGE
static void prefer_huge_pages(void *block, size_t nbytes)
{
    uintptr_t first = ((uintptr_t)block + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
    uintptr_t end = ((uintptr_t)block + nbytes) / HUGE_PAGE * HUGE_PAGE;
    if (nbytes >= HUGE_PAGE && end > first)
        (void)madvise((void *)first, end - first, MADV_HUGEPAGE);
}
#else
#define prefer_huge_pages(block, nbytes) ((void)(block), (void)(nbytes))
#endif

static void *counted(void *block, size_t nbytes)
{
    if (!block)
        return NULL;
    prefer_huge_pages(block, nbytes);
    atomic_fetch_add_explicit(&live_count, 1, memory_order_relaxed);
    return block;
}

void *rmap_alloc(size_t n, size_t size)
{
    return must_fail() ? NULL : counted(calloc(n ? n : 1, size ? size : 1), n * size);
}

void *rmap_alloc_unset(size_t n, size_t size)
{
    void *block = NULL;
    if (must_fail() || (size && n > SIZE_MAX / size))
        return NULL;
    const size_t nbytes = n * size;
    if (nbytes < HUGE_PAGE)
        block = malloc(nbytes > 0 ? nbytes : 1);
    else if (posix_memalign(&block, HUGE_PAGE, nbytes) != 0)
        return NULL;
    return counted(block, nbytes);
}

void *rmap_realloc(void *block, size_t n, size_t size)
{
    if (!block)
        return rmap_alloc(n, size);
    if (must_fail() || (size && n > SIZE_MAX / size))
        return NULL;
    size_t bytes = n * size;
    void *grown = realloc(block, bytes ? bytes : 1);
    if (grown)
        prefer_huge_pages(grown, bytes);
    return grown;
}

char *rmap_strdup(const char *text)
{
    if (!text)
        return NULL;
    size_t bytes = strlen(text) + 1;
    char *copy = rmap_alloc(bytes, 1);
    if (copy)
        memcpy(copy, text, bytes);
    return copy;
}

void rmap_free(void *block)
{
    if (!block)
        return;
    atomic_fetch_sub_explicit(&live_count, 1, memory_order_relaxed);
    free(block);
}

enum rmap_status rmap_reserve(void **block, size_t *cap, size_t need, size_t size,
                              struct rmap_error *err)
{
    if (need <= *cap)
        return RMAP_OK;
    size_t wanted = *cap ? *cap : 16;
    while (wanted < need) {
        if (wanted > SIZE_MAX / 2)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu elements wanted", need);
        wanted *= 2;
    }
    void *grown = rmap_realloc(*block, wanted, size);
    if (!grown)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu elements of %zu bytes", wanted,
                              size);
    *block = grown;
    *cap = wanted;
    return RMAP_OK;
}

/* A pointer's bytes are copied: to take it for one to void would be undefined. */
enum rmap_status rmap_reserve_array(void *array_address, size_t *cap, size_t need, size_t size,
                                    struct rmap_error *err)
{
    void *block;
    memcpy(&block, array_address, sizeof block);
    enum rmap_status st = rmap_reserve(&block, cap, need, size, err);
    memcpy(array_address, &block, sizeof block);
    return st;
}

int64_t rmap_alloc_live(void)
{
    return atomic_load(&live_count);
}

void rmap_alloc_fail_at(int64_t fail_at)
{
    atomic_store(&fail_countdown, fail_at);
}
