/* SPDX-License-Identifier: MIT */
#include "analysis/key_sums.h"

#include "base/alloc.h"

enum { SLOTS_FIRST = 1024 };

/* Three quarters of the slots are used at most. */
static size_t slots_for(size_t n)
{
    size_t n_slot = SLOTS_FIRST;
    while (n_slot / 4 * 3 < n)
        n_slot *= 2;
    return n_slot;
}

size_t rmap_key_sums_nbytes(size_t most)
{
    return slots_for(most) * sizeof(struct rmap_key_sum);
}

void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most)
{
    *sums = (struct rmap_key_sums){.most = most};
}

void rmap_key_sums_fini(struct rmap_key_sums *sums)
{
    rmap_free(sums->slot);
    *sums = (struct rmap_key_sums){.most = sums->most};
}

static inline size_t slot_of(const struct rmap_key_sums *sums, struct rmap_key key)
{
    uint64_t mixed =
        (key.low ^ key.high * UINT64_C(0x9e3779b97f4a7c15)) * UINT64_C(0xd6e8feb86659fd93);
    return (size_t)(mixed >> 32) & (sums->n_slot - 1);
}

/* Where the key is, or the free slot where it would be. */
static inline size_t look_up(const struct rmap_key_sums *sums, struct rmap_key key)
{
    size_t at = slot_of(sums, key);
    while (sums->slot[at].key.high != 0 &&
           (sums->slot[at].key.low != key.low || sums->slot[at].key.high != key.high))
        at = (at + 1) & (sums->n_slot - 1);
    return at;
}

static enum rmap_status grow(struct rmap_key_sums *sums, struct rmap_error *err)
{
    struct rmap_key_sums wider = {.n_slot = slots_for(sums->n + 1), .most = sums->most};
    if (sums->n_slot >= wider.n_slot)
        wider.n_slot = 2 * sums->n_slot;
    wider.slot = rmap_alloc(wider.n_slot, sizeof *wider.slot);
    if (!wider.slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", sums->n);
    for (size_t i = 0; i < sums->n_slot; i++)
        if (sums->slot[i].key.high != 0)
            wider.slot[look_up(&wider, sums->slot[i].key)] = sums->slot[i];
    wider.n = sums->n;
    rmap_free(sums->slot);
    *sums = wider;
    return RMAP_OK;
}

enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *entry_ret = NULL;
    size_t at = sums->n_slot > 0 ? look_up(sums, key) : 0;
    if (sums->n_slot == 0 || sums->slot[at].key.high == 0) {
        if (sums->n == sums->most)
            return RMAP_OK;
        if (sums->n + 1 > sums->n_slot / 4 * 3) {
            RMAP_TRY(grow(sums, err));
            at = look_up(sums, key);
        }
        sums->slot[at] = (struct rmap_key_sum){.key = key};
        sums->n++;
    }
    *entry_ret = &sums->slot[at];
out:
    return st;
}

const struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums, struct rmap_key key)
{
    if (sums->n_slot == 0)
        return NULL;
    const struct rmap_key_sum *found = &sums->slot[look_up(sums, key)];
    return found->key.high != 0 ? found : NULL;
}

void rmap_key_sums_expect(const struct rmap_key_sums *sums, struct rmap_key key)
{
    if (sums->n_slot > 0)
        __builtin_prefetch(&sums->slot[slot_of(sums, key)], 1);
}

enum rmap_status rmap_key_sums_list(const struct rmap_key_sums *sums,
                                    struct rmap_key_sum **list_ret, struct rmap_error *err)
{
    struct rmap_key_sum *list = rmap_alloc(sums->n + 1, sizeof *list);
    size_t n = 0;
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", sums->n);
    for (size_t i = 0; i < sums->n_slot; i++)
        if (sums->slot[i].key.high != 0)
            list[n++] = sums->slot[i];
    *list_ret = list;
    return RMAP_OK;
}
