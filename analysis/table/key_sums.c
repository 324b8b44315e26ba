/* SPDX-License-Identifier: MIT
 *
 * Linear probing in at least twice as many slots as there are keys.
 */
#include "analysis/table/key_sums.h"

#include "base/alloc.h"

enum { SLOTS_FIRST = 64 };

void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most)
{
    *sums = (struct rmap_key_sums){.most = most};
}

void rmap_key_sums_fini(struct rmap_key_sums *sums)
{
    rmap_free(sums->entry);
    rmap_free(sums->slot);
    *sums = (struct rmap_key_sums){.most = sums->most};
}

/* The slot that has the key, or the free one where it would be. There are free ones. */
static size_t slot_of(const struct rmap_key_sums *sums, struct rmap_key key)
{
    uint64_t mixed = (key.low ^ key.high * UINT64_C(0x9e3779b97f4a7c15));
    mixed = (mixed ^ mixed >> 32) * UINT64_C(0xd6e8feb86659fd93);
    size_t at = (size_t)(mixed >> 32) & (sums->n_slot - 1);
    while (sums->slot[at] && !rmap_keys_equal(sums->entry[sums->slot[at] - 1].key, key))
        at = (at + 1) & (sums->n_slot - 1);
    return at;
}

struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums, struct rmap_key key)
{
    if (sums->n_slot == 0)
        return NULL;
    const uint32_t found = sums->slot[slot_of(sums, key)];
    return found ? &sums->entry[found - 1] : NULL;
}

static enum rmap_status widen(struct rmap_key_sums *sums, struct rmap_error *err)
{
    const size_t n_slot = sums->n_slot ? 2 * sums->n_slot : SLOTS_FIRST;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu keys", sums->n);
    rmap_free(sums->slot);
    sums->slot = slot;
    sums->n_slot = n_slot;
    for (size_t i = 0; i < sums->n; i++)
        slot[slot_of(sums, sums->entry[i].key)] = (uint32_t)i + 1;
    return RMAP_OK;
}

enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *entry_ret = NULL;
    if (2 * (sums->n + 1) > sums->n_slot)
        RMAP_TRY(widen(sums, err));
    const size_t at = slot_of(sums, key);
    if (!sums->slot[at] && sums->n == sums->most)
        goto out;
    if (!sums->slot[at]) {
        RMAP_TRY(RMAP_RESERVE(sums->entry, sums->cap, sums->n + 1, err));
        sums->entry[sums->n] = (struct rmap_key_sum){.key = key};
        sums->slot[at] = (uint32_t)++sums->n;
    }
    *entry_ret = &sums->entry[sums->slot[at] - 1];
out:
    return st;
}
