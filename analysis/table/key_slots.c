/* SPDX-License-Identifier: MIT */
#include "analysis/table/key_slots.h"

#include <string.h>

#include "base/alloc.h"

/* Slots grow to SLOTS_FEW, then there are enough for all, or SLOTS_MANY at once: to move to more of
 * them costs as much as what came until then. SLOTS_HUGE fill a huge page, and many are no fewer:
 * pages of 4 KiB would have to be found one by one. */
enum {
    SLOTS_FIRST = 4096,
    SLOTS_FEW = 1 << 14,
    SLOTS_SOME = 1 << 16,
    SLOTS_HUGE = 1 << 19,
    SLOTS_MANY = 1 << 20
};

/* Three quarters of the slots are used at most. */
static size_t room_of(size_t n_slot)
{
    return n_slot / 4 * 3;
}

static size_t slots_for(size_t n)
{
    size_t n_slot = SLOTS_FIRST;
    while (room_of(n_slot) < n)
        n_slot *= 2;
    return n_slot;
}

void rmap_key_slots_init(struct rmap_key_slots *slots, size_t most)
{
    uint32_t number = 1;
    while (number < most)
        number = 2 * number + 1;
    *slots = (struct rmap_key_slots){.most = most, .number = number};
}

void rmap_key_slots_fini(struct rmap_key_slots *slots)
{
    rmap_free(slots->slot);
    *slots = (struct rmap_key_slots){.most = slots->most, .number = slots->number};
}

static size_t slots_behind(size_t n_slot, size_t most)
{
    if (n_slot >= SLOTS_MANY)
        return 2 * n_slot;
    size_t many = n_slot == 0 ? SLOTS_FIRST : n_slot < SLOTS_FEW ? SLOTS_FEW : SLOTS_MANY;
    many = many < most ? many : most;
    return many > SLOTS_SOME && many < SLOTS_HUGE ? SLOTS_HUGE : many;
}

/* Of the i-th entry. */
static inline uint64_t mixed_at(const void *first_key, size_t stride, size_t i)
{
    struct rmap_key key;
    memcpy(&key, (const char *)first_key + i * stride, sizeof key);
    return rmap_key_mixed(key);
}

/* Slots are asked for so many entries ahead. */
enum { AHEAD = 32 };

enum rmap_status rmap_key_slots_grow(struct rmap_key_slots *slots, const void *first_key,
                                     size_t stride, size_t n, struct rmap_error *err)
{
    const size_t n_slot = slots_behind(slots->n_slot, slots_for(slots->most));
    uint32_t *slot = rmap_alloc_unset(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums by %zu keys", n);
    memset(slot, 0, n_slot * sizeof *slot);
    rmap_free(slots->slot);
    slots->slot = slot;
    slots->n_slot = n_slot;
    slots->room = room_of(n_slot);
    for (size_t i = 0; i < n; i++) {
        const uint64_t mixed = mixed_at(first_key, stride, i);
        if (i + AHEAD < n) {
            const uint64_t next = mixed_at(first_key, stride, i + AHEAD);
            __builtin_prefetch(&slot[rmap_key_slots_at(slots, next)], 1);
        }
        size_t at = rmap_key_slots_at(slots, mixed);
        while (slot[at] != 0)
            at = (at + 1) & (n_slot - 1);
        rmap_key_slots_put(slots, at, mixed, i);
    }
    return RMAP_OK;
}
