/* SPDX-License-Identifier: MIT
 *
 * Sums by keys of 128 bits, in entries of 64 bytes, a line of a cache each. The table holds a
 * stated number of keys and never more, and says so when it is full: whether it is depends on the
 * keys alone, not on their order.
 */
#ifndef RMAP_KEY_SUMS_H
#define RMAP_KEY_SUMS_H

#include "analysis/table/key_slots.h"

struct rmap_key_sum {
    struct rmap_key key;
    double weight, weight_squared;
    uint64_t number[4]; /* what they are is the user's; 0 in a new entry */
};

struct rmap_key_sums {
    struct rmap_key_sum *entry; /* [n_entry]: a few, or room for `most` whose pages come with use */
    struct rmap_key_slots slots;
    size_t n_entry, n;
};

/* most: keys, below RMAP_KEY_SLOTS_MOST. */
void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most);
void rmap_key_sums_fini(struct rmap_key_sums *sums);

/* The key's entry, or NULL. */
struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums, struct rmap_key key);

/* The key's entry, which is new where weight and numbers are all 0. *entry_ret: NULL when the table
 * is full and has no such key. Valid until the next call. RMAP_SYSTEM. */
enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* All entries [n], in no order: rmap_free. */
enum rmap_status rmap_key_sums_list(const struct rmap_key_sums *sums,
                                    struct rmap_key_sum **list_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
