/* SPDX-License-Identifier: MIT */
#include "analysis/key_sums.h"

#include "base/alloc.h"

enum { SLOTS_FIRST = 1024, GROWTH = 4 };

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

static enum rmap_status grow(struct rmap_key_sums *sums, struct rmap_error *err)
{
    const size_t most = slots_for(sums->most), many = sums->n_slot * GROWTH;
    struct rmap_key_sums wider = {.n_slot = many < most ? many : most, .most = sums->most};
    if (sums->n_slot == 0)
        wider.n_slot = SLOTS_FIRST;
    wider.slot = rmap_alloc(wider.n_slot, sizeof *wider.slot);
    if (!wider.slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", sums->n);
    for (size_t i = 0; i < sums->n_slot; i++)
        if (sums->slot[i].key.high != 0)
            wider.slot[rmap_key_sums_place(&wider, sums->slot[i].key)] = sums->slot[i];
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
    size_t at = sums->n_slot > 0 ? rmap_key_sums_place(sums, key) : 0;
    if (sums->n_slot == 0 || sums->slot[at].key.high == 0) {
        if (sums->n == sums->most)
            return RMAP_OK;
        if (sums->n + 1 > sums->n_slot / 4 * 3) {
            RMAP_TRY(grow(sums, err));
            at = rmap_key_sums_place(sums, key);
        }
        sums->slot[at] = (struct rmap_key_sum){.key = key};
        sums->n++;
    }
    *entry_ret = &sums->slot[at];
out:
    return st;
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
