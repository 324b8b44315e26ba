/* SPDX-License-Identifier: MIT
 *
 * Sums by keys of 128 bits: a hash table with open addressing. It holds a stated number of keys and
 * never more, and says so when it is full: whether it is depends on the keys alone, not on their
 * order.
 */
#ifndef RMAP_KEY_SUMS_H
#define RMAP_KEY_SUMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_key {
    uint64_t low, high; /* high: not 0 */
};

static inline bool rmap_keys_equal(struct rmap_key a, struct rmap_key b)
{
    return a.low == b.low && a.high == b.high;
}

struct rmap_key_sum {
    struct rmap_key key;
    double weight, weight_squared;
    uint64_t number[6]; /* what they are is the user's; 0 in a new entry */
};

struct rmap_key_sums {
    struct rmap_key_sum *entry; /* [n] in the order in which keys came */
    size_t n, cap, most;
    uint32_t *slot; /* [n_slot] 1 + entry; 0: free. A power of two */
    size_t n_slot;
};

/* most: keys, fewer than 2^31. */
void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most);
void rmap_key_sums_fini(struct rmap_key_sums *sums);

/* The key's entry, or NULL. */
struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums, struct rmap_key key);

/* The key's entry, which is new where weight and numbers are all 0. *entry_ret: NULL when the table
 * is full and has no such key. Valid until the next call. RMAP_SYSTEM. */
enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
