/* SPDX-License-Identifier: MIT */
#include "analysis/table/key_sums.h"

#include <string.h>

#include "base/alloc.h"

enum { ENTRIES_FEW = 1 << 10, STRIDE = sizeof(struct rmap_key_sum) };

void rmap_key_sums_init(struct rmap_key_sums *sums, size_t most)
{
    *sums = (struct rmap_key_sums){0};
    rmap_key_slots_init(&sums->slots, most);
}

void rmap_key_sums_fini(struct rmap_key_sums *sums)
{
    rmap_free(sums->entry);
    rmap_key_slots_fini(&sums->slots);
    sums->entry = NULL;
    sums->n = sums->n_entry = 0;
}

struct rmap_key_sum *rmap_key_sums_find(const struct rmap_key_sums *sums, struct rmap_key key)
{
    size_t slot, at = RMAP_KEY_SLOTS_NONE;
    if (sums->slots.n_slot > 0)
        at =
            rmap_key_slots_look(&sums->slots, sums->entry, STRIDE, key, rmap_key_mixed(key), &slot);
    return at != RMAP_KEY_SLOTS_NONE ? &sums->entry[at] : NULL;
}

/* For another entry. */
static enum rmap_status make_room(struct rmap_key_sums *sums, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t most = sums->slots.most;
    const size_t n = sums->n_entry == 0 && most > ENTRIES_FEW ? ENTRIES_FEW : most;
    if (sums->n >= sums->n_entry) {
        struct rmap_key_sum *entry = rmap_alloc_unset(n, sizeof *entry);
        if (!entry)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", n);
        if (sums->n > 0)
            memcpy(entry, sums->entry, sums->n * sizeof *entry);
        rmap_free(sums->entry);
        sums->entry = entry;
        sums->n_entry = n;
    }
    if (sums->n >= sums->slots.room)
        st = rmap_key_slots_grow(&sums->slots, sums->entry, STRIDE, sums->n, err);
    return st;
}

enum rmap_status rmap_key_sums_enter(struct rmap_key_sums *sums, struct rmap_key key,
                                     struct rmap_key_sum **entry_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t mixed = rmap_key_mixed(key);
    size_t slot = 0, at = RMAP_KEY_SLOTS_NONE;
    *entry_ret = NULL;
    if (sums->slots.n_slot > 0)
        at = rmap_key_slots_look(&sums->slots, sums->entry, STRIDE, key, mixed, &slot);
    if (at != RMAP_KEY_SLOTS_NONE) {
        *entry_ret = &sums->entry[at];
        return RMAP_OK;
    }
    if (sums->n == sums->slots.most)
        return RMAP_OK;
    if (sums->n >= sums->n_entry || sums->n >= sums->slots.room) {
        RMAP_TRY(make_room(sums, err));
        (void)rmap_key_slots_look(&sums->slots, sums->entry, STRIDE, key, mixed, &slot);
    }
    rmap_key_slots_put(&sums->slots, slot, mixed, sums->n);
    *entry_ret = &sums->entry[sums->n++];
    **entry_ret = (struct rmap_key_sum){.key = key};
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
