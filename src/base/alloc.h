/* SPDX-License-Identifier: MIT
 *
 * Memory through one door: overflow-checked, countable by tests, failable by tests.
 */
#ifndef RMAP_ALLOC_H
#define RMAP_ALLOC_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Zeroed memory for n elements of size bytes; NULL when it cannot be had. rmap_free releases. */
void *rmap_alloc(size_t n, size_t size);

/* The same, but what the memory holds is undefined; from 2 MiB on it is on huge pages. */
void *rmap_alloc_unset(size_t n, size_t size);

/* Grows or shrinks a block of rmap_alloc to n elements of size bytes; new bytes are undefined.
 * NULL when it cannot be had: the old block then stands unchanged. */
void *rmap_realloc(void *block, size_t n, size_t size);

/* A copy of the text; NULL when memory is short (or text is NULL). */
char *rmap_strdup(const char *text);

void rmap_free(void *block); /* NULL is fine */

/* Makes room for `need` elements in *block, whose capacity is *cap elements, by doubling.
 * RMAP_SYSTEM with *block and *cap unchanged when memory is short. */
enum rmap_status rmap_reserve(void **block, size_t *cap, size_t need, size_t size,
                              struct rmap_error *err) RMAP_MUST_USE;

/* The same of an array and its capacity, both of which are lvalues. */
#define RMAP_RESERVE(array, cap, need, err)                                                        \
    rmap_reserve_array(&(array), &(cap), (need), sizeof *(array), (err))
enum rmap_status rmap_reserve_array(void *array_address, size_t *cap, size_t need, size_t size,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Test hooks. Blocks alive now; and: the fail_at-th allocation from now on fails (0: never). */
int64_t rmap_alloc_live(void);
void rmap_alloc_fail_at(int64_t fail_at);

#endif
