/* SPDX-License-Identifier: MIT
 *
 * Where the entry of a key of 128 bits stands: entries, each beginning with its key, stand in the
 * order in which their keys came; an open-addressing table of small slots, of which many fit into a
 * cache, tells the number of each.
 */
#ifndef RMAP_KEY_SLOTS_H
#define RMAP_KEY_SLOTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "analysis/table/key_lanes.h"
#include "base/status.h"
#include "base/wide.h"

struct rmap_key {
    uint64_t low, high; /* high: not 0 */
};

/* Entries that a table may be asked to hold. */
#define RMAP_KEY_SLOTS_MOST ((size_t)1 << 31)

/* What is looked for and not there. */
#define RMAP_KEY_SLOTS_NONE SIZE_MAX

struct rmap_key_slots {
    uint32_t *slot;  /* [n_slot]; 0: free; else index of an entry + 1, and bits of its key above */
    uint32_t number; /* bits of a slot that are the index */
    size_t n_slot;
    size_t room; /* entries for which there are slots enough */
    size_t most; /* entries */
};

/* most: below RMAP_KEY_SLOTS_MOST. */
void rmap_key_slots_init(struct rmap_key_slots *slots, size_t most);
void rmap_key_slots_fini(struct rmap_key_slots *slots);

/* Makes more room; first_key: of n entries, one every `stride` bytes. RMAP_SYSTEM. */
enum rmap_status rmap_key_slots_grow(struct rmap_key_slots *slots, const void *first_key,
                                     size_t stride, size_t n, struct rmap_error *err) RMAP_MUST_USE;

static inline uint64_t rmap_key_mixed(struct rmap_key key)
{
    return (key.low ^ key.high * UINT64_C(0x9e3779b97f4a7c15)) * UINT64_C(0xd6e8feb86659fd93);
}

/* The first of the slots that are looked at together for a key; where all are taken, it goes on
 * with the next ones. Taken ones come first. */
static inline size_t rmap_key_slots_at(const struct rmap_key_slots *slots, uint64_t mixed)
{
    return (size_t)(mixed >> 16) & (slots->n_slot - 1) & ~(size_t)(RMAP_KEY_SLOTS_TOGETHER - 1);
}

/* Bits of a key, mixed, that its slot has above the index. */
static inline uint32_t rmap_key_slots_bits(const struct rmap_key_slots *slots, uint64_t mixed)
{
    return (uint32_t)(mixed >> 32) & ~slots->number;
}

/* Index of the key's entry, or NONE; *slot_ret: where it is, or the free slot where it would be.
 * There are slots. */
RMAP_COPIED size_t rmap_key_slots_look(const struct rmap_key_slots *slots, const void *first_key,
                                       size_t stride, struct rmap_key key, uint64_t mixed,
                                       size_t *slot_ret)
{
    const uint32_t bits = rmap_key_slots_bits(slots, mixed);
    for (size_t at = rmap_key_slots_at(slots, mixed);;
         at = (at + RMAP_KEY_SLOTS_TOGETHER) & (slots->n_slot - 1)) {
        const struct rmap_key_lanes lanes =
            rmap_key_lanes_of(slots->slot + at, slots->number, bits, false);
        for (uint32_t left = lanes.alike; left != 0; left &= left - 1) {
            const size_t slot = at + rmap_key_lane(left);
            const size_t index = (slots->slot[slot] & slots->number) - 1;
            const struct rmap_key *its =
                (const struct rmap_key *)(const void *)((const char *)first_key + index * stride);
            if (its->low == key.low && its->high == key.high) {
                *slot_ret = slot;
                return index;
            }
        }
        if (lanes.free != 0) {
            *slot_ret = at + rmap_key_lane(lanes.free);
            return RMAP_KEY_SLOTS_NONE;
        }
    }
}

/* The entry `index` of a key for which there is room; slot: as found by rmap_key_slots_look. */
static inline void rmap_key_slots_put(struct rmap_key_slots *slots, size_t slot, uint64_t mixed,
                                      size_t index)
{
    slots->slot[slot] = rmap_key_slots_bits(slots, mixed) | (uint32_t)(index + 1);
}

/* Keys, mixed, that will be asked for soon: into the second cache, as the first has no lines for as
 * many at once. Copied, as is the next: where it need not, the compiler takes a function that but
 * prefetches for one without effect. */
RMAP_COPIED void rmap_key_slots_expect(const struct rmap_key_slots *slots, const uint64_t *mixed,
                                       size_t n)
{
    for (size_t i = 0; i < n && slots->n_slot > 0; i++)
        __builtin_prefetch(&slots->slot[rmap_key_slots_at(slots, mixed[i])], 0, 2);
}

/* Later: the slots are there by now, and tell of entries. */
RMAP_COPIED void rmap_key_slots_expect_entries(const struct rmap_key_slots *slots,
                                               const void *first_key, size_t stride,
                                               const uint64_t *mixed, size_t n)
{
    for (size_t i = 0; i < n && slots->n_slot > 0; i++) {
        const uint32_t *slot = slots->slot + rmap_key_slots_at(slots, mixed[i]);
        const uint32_t bits = rmap_key_slots_bits(slots, mixed[i]);
        const struct rmap_key_lanes lanes = rmap_key_lanes_of(slot, slots->number, bits, false);
        const uint32_t found =
            slot[rmap_key_lane(lanes.alike | 1u << (RMAP_KEY_SLOTS_TOGETHER - 1))];
        const uintptr_t behind = (uintptr_t)first_key + (found & slots->number) * stride;
        __builtin_prefetch((const void *)(behind - stride), 1); /* of a free slot: anything */
    }
}

#endif
