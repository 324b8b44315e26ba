/* SPDX-License-Identifier: MIT
 *
 * Many like items done by the threads of a rank, while the calling thread shows progress and does
 * what it alone may do.
 */
#ifndef RMAP_PARTS_H
#define RMAP_PARTS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct rmap_parts {
    size_t first, last, step; /* items [first, last), `step` at a time to whoever is free */
    void *context;
    /* On any thread in [0, n_thread): items [first, last) of a part. */
    enum rmap_status (*work)(void *context, int thread, size_t first, size_t last,
                             struct rmap_error *err);
    /* On the calling thread, every millisecond; NULL: nothing. */
    enum rmap_status (*meanwhile)(void *context, struct rmap_error *err);
    _Atomic bool abandoned; /* one of them failed: the others may stop early */
};

/* Makes `step` smaller, if need be, so that all threads get as many parts of the same size. */
void rmap_parts_even(struct rmap_parts *parts, int n_thread);

/* Not collective. The status of the lowest thread that failed. */
enum rmap_status rmap_parts_run(struct rmap_parts *parts, int n_thread,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Item i of n of a collective share: contiguous, about the same work on every rank. An item
 * belongs where it begins. */
void rmap_parts_share(struct rmap_parts *parts, double (*work_of)(void *context, size_t item),
                      size_t n, int rank, int size);

#endif
