/* SPDX-License-Identifier: MIT */
#include "analysis/key_sums.h"

#include <string.h>

#include "base/alloc.h"

/* Slots grow to SLOTS_FEW, then fill a huge page. */
enum { SLOTS_FIRST = 4096, SLOTS_FEW = 1 << 14, SLOTS_MANY = 1 << 19, ENTRIES_FEW = 1 << 10 };

/* Three quarters of the slots are used at most. */
static size_t slots_for(size_t n)
{
    size_t n_slot = SLOTS_FIRST;
    while (n_slot / 4 * 3 < n)
        n_slot *= 2;
    return n_slot;
}

void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most)
{
    uint32_t number = 1;
    while (number < most)
        number = 2 * number + 1;
    *sums = (struct rmap_key_sums){.most = most, .number = number};
}

void rmap_key_sums_fini(struct rmap_key_sums *sums)
{
    rmap_free(sums->entry);
    rmap_free(sums->slot);
    *sums = (struct rmap_key_sums){.most = sums->most, .number = sums->number};
}

static size_t slots_behind(size_t n_slot, size_t most)
{
    const size_t many = n_slot == 0           ? SLOTS_FIRST
                        : n_slot < SLOTS_FEW  ? SLOTS_FEW
                        : n_slot < SLOTS_MANY ? SLOTS_MANY
                                              : 2 * n_slot;
    return many < most ? many : most;
}

static enum rmap_status grow(struct rmap_key_sums *sums, struct rmap_error *err)
{
    const size_t n_slot = slots_behind(sums->n_slot, slots_for(sums->most));
    uint32_t *slot = rmap_alloc_unset(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", sums->n);
    memset(slot, 0, n_slot * sizeof *slot);
    rmap_free(sums->slot);
    sums->slot = slot;
    sums->n_slot = n_slot;
    for (size_t i = 0; i < sums->n; i++) {
        const uint64_t mixed = rmap_key_sums_mixed(sums->entry[i].key);
        size_t at = rmap_key_sums_slot(sums, mixed);
        while (slot[at] != 0)
            at = (at + 1) & (n_slot - 1);
        slot[at] = ((uint32_t)(mixed >> 32) & ~sums->number) | (uint32_t)(i + 1);
    }
    return RMAP_OK;
}

/* For another entry. */
static enum rmap_status make_room(struct rmap_key_sums *sums, struct rmap_error *err)
{
    if (sums->n < sums->n_entry)
        return RMAP_OK;
    const size_t n = sums->n_entry == 0 && sums->most > ENTRIES_FEW ? ENTRIES_FEW : sums->most;
    struct rmap_key_sum *entry = rmap_alloc_unset(n, sizeof *entry);
    if (!entry)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", n);
    if (sums->n > 0)
        memcpy(entry, sums->entry, sums->n * sizeof *entry);
    rmap_free(sums->entry);
    sums->entry = entry;
    sums->n_entry = n;
    return RMAP_OK;
}

enum rmap_status rmap_key_sums_add(struct rmap_key_sums *sums, struct rmap_key key, size_t slot,
                                   struct rmap_key_sum **entry_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *entry_ret = NULL;
    if (sums->n == sums->most)
        return RMAP_OK;
    RMAP_TRY(make_room(sums, err));
    if (sums->n + 1 > sums->n_slot / 4 * 3) {
        RMAP_TRY(grow(sums, err));
        (void)rmap_key_sums_look(sums, key, rmap_key_sums_mixed(key), &slot);
    }
    *entry_ret = rmap_key_sums_put(sums, key, rmap_key_sums_mixed(key), slot);
    sums->room = sums->n_slot / 4 * 3;
    sums->room = sums->n_entry < sums->room ? sums->n_entry : sums->room;
out:
    return st;
}

enum rmap_status rmap_key_sums_list(const struct rmap_key_sums *sums,
                                    struct rmap_key_sum **list_ret, struct rmap_error *err)
{
    struct rmap_key_sum *list = rmap_alloc_unset(sums->n + 1, sizeof *list);
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", sums->n);
    if (sums->n > 0)
        memcpy(list, sums->entry, sums->n * sizeof *list);
    *list_ret = list;
    return RMAP_OK;
}
