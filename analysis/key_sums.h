/* SPDX-License-Identifier: MIT
 *
 * Sums by keys of 128 bits. Entries of 64 bytes, a line of a cache each, stand in the order in
 * which their keys came; an open-addressing table of small slots, of which many fit into a cache,
 * tells where. It holds a stated number of keys and never more, and says so when it is full:
 * whether it is depends on the keys alone, not on their order.
 */
#ifndef RMAP_KEY_SUMS_H
#define RMAP_KEY_SUMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/wide.h"

struct rmap_key {
    uint64_t low, high; /* high: not 0 */
};

struct rmap_key_sum {
    struct rmap_key key;
    double weight, weight_squared;
    uint64_t number[4]; /* what they are is the user's; 0 in a new entry */
};

/* Keys that it may be asked to hold. */
#define RMAP_KEY_SUMS_MOST ((size_t)1 << 31)

struct rmap_key_sums {
    struct rmap_key_sum *entry; /* [n_entry]: a few, or room for `most` whose pages come with use */
    uint32_t *slot;  /* [n_slot]; 0: free; else index of an entry + 1, and bits of its key above */
    uint32_t number; /* bits of a slot that are the index */
    size_t n_slot, n_entry, n;
    size_t most; /* keys */
    size_t room; /* as many entries fit into what is there */
};

/* most: below RMAP_KEY_SUMS_MOST. */
void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most);
void rmap_key_sums_fini(struct rmap_key_sums *sums);

static inline uint64_t rmap_key_sums_mixed(struct rmap_key key)
{
    return (key.low ^ key.high * UINT64_C(0x9e3779b97f4a7c15)) * UINT64_C(0xd6e8feb86659fd93);
}

static inline size_t rmap_key_sums_slot(const struct rmap_key_sums *sums, uint64_t mixed)
{
    return (size_t)(mixed >> 20) & (sums->n_slot - 1);
}

/* The key's entry, or NULL; *slot_ret: where it is, or the free slot where it would be. There are
 * slots. */
static inline struct rmap_key_sum *rmap_key_sums_look(const struct rmap_key_sums *sums,
                                                      struct rmap_key key, uint64_t mixed,
                                                      size_t *slot_ret)
{
    const uint32_t bits = (uint32_t)(mixed >> 32);
    size_t at = rmap_key_sums_slot(sums, mixed);
    for (uint32_t found; (found = sums->slot[at]) != 0; at = (at + 1) & (sums->n_slot - 1)) {
        if ((found ^ bits) & ~sums->number)
            continue;
        struct rmap_key_sum *sum = &sums->entry[(found & sums->number) - 1];
        if (sum->key.low == key.low && sum->key.high == key.high) {
            *slot_ret = at;
            return sum;
        }
    }
    *slot_ret = at;
    return NULL;
}

/* The key's entry, or NULL. */
static inline struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums,
                                                      struct rmap_key key)
{
    size_t slot;
    return sums->n_slot > 0 ? rmap_key_sums_look(sums, key, rmap_key_sums_mixed(key), &slot) : NULL;
}

/* A new entry for which there is room; slot: as found by rmap_key_sums_look. */
static inline struct rmap_key_sum *
rmap_key_sums_put(struct rmap_key_sums *sums, struct rmap_key key, uint64_t mixed, size_t slot)
{
    struct rmap_key_sum *entry = &sums->entry[sums->n++];
    *entry = (struct rmap_key_sum){.key = key};
    sums->slot[slot] = ((uint32_t)(mixed >> 32) & ~sums->number) | (uint32_t)sums->n;
    return entry;
}

/* Of a key that is not there, making room; slot: as found by rmap_key_sums_look. */
enum rmap_status rmap_key_sums_add(struct rmap_key_sums *sums, struct rmap_key key, size_t slot,
                                   struct rmap_key_sum **entry_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The same as below, for who has mixed the key. */
static inline RMAP_MUST_USE enum rmap_status
rmap_key_sums_enter_mixed(struct rmap_key_sums *sums, struct rmap_key key, uint64_t mixed,
                          struct rmap_key_sum **entry_ret, struct rmap_error *err)
{
    size_t slot = 0;
    *entry_ret = sums->n_slot > 0 ? rmap_key_sums_look(sums, key, mixed, &slot) : NULL;
    if (*entry_ret)
        return RMAP_OK;
    if (sums->n >= sums->room)
        return rmap_key_sums_add(sums, key, slot, entry_ret, err);
    *entry_ret = rmap_key_sums_put(sums, key, mixed, slot);
    return RMAP_OK;
}

/* The key's entry, which is new where weight and numbers are all 0. *entry_ret: NULL when the table
 * is full and has no such key. Valid until the next call. RMAP_SYSTEM. */
static inline RMAP_MUST_USE enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums,
                                                                 struct rmap_key key,
                                                                 struct rmap_key_sum **entry_ret,
                                                                 struct rmap_error *err)
{
    return rmap_key_sums_enter_mixed(sums, key, rmap_key_sums_mixed(key), entry_ret, err);
}

/* The key will be asked for soon. Copied: where it need not, the compiler takes a function that but
 * prefetches for one without effect. */
RMAP_COPIED void rmap_key_sums_expect(const struct rmap_key_sums *sums, struct rmap_key key)
{
    if (sums->n_slot > 0)
        __builtin_prefetch(&sums->slot[rmap_key_sums_slot(sums, rmap_key_sums_mixed(key))], 0);
}

/* The same of many keys, mixed. */
RMAP_COPIED void rmap_key_sums_expect_slots(const struct rmap_key_sums *sums, const uint64_t *mixed,
                                            size_t n)
{
    for (size_t i = 0; i < n && sums->n_slot > 0; i++)
        __builtin_prefetch(&sums->slot[rmap_key_sums_slot(sums, mixed[i])], 1);
}

/* Later: the slots are there by now, and tell of entries. */
RMAP_COPIED void rmap_key_sums_expect_entries(const struct rmap_key_sums *sums,
                                              const uint64_t *mixed, size_t n)
{
    for (size_t i = 0; i < n && sums->n_slot > 0; i++) {
        const uint32_t found = sums->slot[rmap_key_sums_slot(sums, mixed[i])];
        __builtin_prefetch(&sums->entry[(found & sums->number) - (found != 0)], 1);
    }
}

/* All entries [n], in no order: rmap_free. */
enum rmap_status rmap_key_sums_list(const struct rmap_key_sums *sums,
                                    struct rmap_key_sum **list_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
