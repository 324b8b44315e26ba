/* SPDX-License-Identifier: MIT
 *
 * Memory that is taken piece by piece and let go as a whole. Pieces stay where they are.
 */
#ifndef RMAP_STATS_STORE_H
#define RMAP_STATS_STORE_H

#include <stddef.h>

#include "base/status.h"

/* All zero is empty. */
struct rmap_stats_store {
    void **chunk; /* [n_chunk] */
    size_t n_chunk, chunk_cap;
    size_t used, size; /* bytes of the last one */
};
void rmap_stats_store_fini(struct rmap_stats_store *store);

/* RMAP_SYSTEM. */
enum rmap_status rmap_stats_store_take(struct rmap_stats_store *store, size_t n, size_t size,
                                       void **piece_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Takes over all of `from`, which is empty then. RMAP_SYSTEM: both are as they were. */
enum rmap_status rmap_stats_store_absorb(struct rmap_stats_store *store,
                                         struct rmap_stats_store *from,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Gives back what was taken since the store was as in `before`, a copy of it. */
void rmap_stats_store_give_back(struct rmap_stats_store *store,
                                const struct rmap_stats_store *before);

#endif
