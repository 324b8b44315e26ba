/* SPDX-License-Identifier: MIT
 *
 * Sums by keys of 128 bits: an open-addressing table of entries of 64 bytes, a line of a cache
 * each. It holds a stated number of keys and never more, and says so when it is full: whether it is
 * depends on the keys alone, not on their order.
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

struct rmap_key_sum {
    struct rmap_key key;
    double weight, weight_squared;
    uint64_t number[4]; /* what they are is the user's; 0 in a new entry */
};

struct rmap_key_sums {
    struct rmap_key_sum *slot; /* [n_slot]; key.high 0: free */
    size_t n_slot, n;
    size_t most; /* keys */
};

/* Memory that a full table takes; while it grows to that, a quarter more. */
size_t rmap_key_sums_nbytes(size_t most);

void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most);
void rmap_key_sums_fini(struct rmap_key_sums *sums);

/* The key's entry, which is new where weight and numbers are all 0. *entry_ret: NULL when the table
 * is full and has no such key. Valid until the next call. RMAP_SYSTEM. */
enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

static inline size_t rmap_key_sums_slot(const struct rmap_key_sums *sums, struct rmap_key key)
{
    const uint64_t mixed =
        (key.low ^ key.high * UINT64_C(0x9e3779b97f4a7c15)) * UINT64_C(0xd6e8feb86659fd93);
    return (size_t)(mixed >> 32) & (sums->n_slot - 1);
}

/* Where the key is, or the free slot where it would be. There are slots. */
static inline size_t rmap_key_sums_place(const struct rmap_key_sums *sums, struct rmap_key key)
{
    size_t at = rmap_key_sums_slot(sums, key);
    while (sums->slot[at].key.high != 0 &&
           (sums->slot[at].key.low != key.low || sums->slot[at].key.high != key.high))
        at = (at + 1) & (sums->n_slot - 1);
    return at;
}

/* The key's entry, or NULL. */
static inline struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums,
                                                      struct rmap_key key)
{
    if (sums->n_slot == 0)
        return NULL;
    struct rmap_key_sum *found = &sums->slot[rmap_key_sums_place(sums, key)];
    return found->key.high != 0 ? found : NULL;
}

/* The key will be asked for soon. */
static inline void rmap_key_sums_expect(const struct rmap_key_sums *sums, struct rmap_key key)
{
    if (sums->n_slot > 0)
        __builtin_prefetch(&sums->slot[rmap_key_sums_slot(sums, key)], 1);
}

/* All entries [n], in no order: rmap_free. */
enum rmap_status rmap_key_sums_list(const struct rmap_key_sums *sums,
                                    struct rmap_key_sum **list_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
