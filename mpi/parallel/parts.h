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

/* Who takes what. */
enum rmap_parts_order {
    RMAP_PARTS_IN_ORDER, /* the next to whoever is free */
    RMAP_PARTS_NEAR /* neighbours to one thread: each has a stretch, and who is through with its own
                       takes over half of what the slowest has left */
};

struct rmap_parts {
    size_t first, last, step; /* items [first, last), `step` at a time; NEAR: fewer in the end */
    enum rmap_parts_order order;
    void *context;
    /* On any thread in [0, n_thread): items [first, last) of a part. */
    enum rmap_status (*work)(void *context, int thread, size_t first, size_t last,
                             struct rmap_error *err);
    /* On the calling thread, every millisecond; NULL: nothing. */
    enum rmap_status (*meanwhile)(void *context, struct rmap_error *err);
    _Atomic bool abandoned; /* one of them failed: the others may stop early */
};

/* Not collective. The status of the lowest thread that failed. */
enum rmap_status rmap_parts_run(struct rmap_parts *parts, int n_thread,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Item i of n of a collective share: contiguous, about the same work on every rank. An item
 * belongs where it begins. */
void rmap_parts_share(struct rmap_parts *parts, double (*work_of)(void *context, size_t item),
                      size_t n, int rank, int size);

#endif
