/* SPDX-License-Identifier: MIT
 *
 * Slots of a table (key_slots.h) that are compared at once: a line of a cache. Most keys are new,
 * or in the first slots that they are looked for in: either is known without a branch.
 */
#ifndef RMAP_KEY_LANES_H
#define RMAP_KEY_LANES_H

#include <stdbool.h>
#include <stdint.h>

#include "base/intrinsics.h"
#include "base/wide.h"

enum { RMAP_KEY_SLOTS_TOGETHER = 16 };

/* A bit for each of the slots. */
struct rmap_key_lanes {
    uint32_t alike; /* taken, with the bits that were looked for */
    uint32_t free;
};

/* The first of some. */
static inline uint32_t rmap_key_lane(uint32_t lanes)
{
#ifdef __GNUC__
    return (uint32_t)__builtin_ctz(lanes);
#else
    uint32_t k = 0;
    while (!(lanes >> k & 1))
        k++;
    return k;
#endif
}

#ifdef RMAP_INTRINSICS
#define RMAP_KEY_LANES_WIDE __attribute__((target("avx512f,avx512bw,avx512vl")))

static inline bool rmap_key_lanes_are_wide(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vl");
}

RMAP_KEY_LANES_WIDE static inline struct rmap_key_lanes
rmap_key_lanes_wide(const uint32_t *slot, uint32_t number, uint32_t bits)
{
    const __m512i its = _mm512_loadu_si512(slot);
    const __m512i other = _mm512_xor_si512(its, _mm512_set1_epi32((int)bits));
    const __mmask16 taken = _mm512_test_epi32_mask(its, its);
    return (struct rmap_key_lanes){
        _mm512_mask_testn_epi32_mask(taken, other, _mm512_set1_epi32((int)~number)),
        (uint16_t)~taken};
}

/* Bytes 0 or 255 for 16 numbers that are 0 or all ones, as bits. */
static inline uint32_t rmap_key_lanes_bits(const __m128i four[4])
{
    return (uint32_t)_mm_movemask_epi8(
        _mm_packs_epi16(_mm_packs_epi32(four[0], four[1]), _mm_packs_epi32(four[2], four[3])));
}

static inline struct rmap_key_lanes rmap_key_lanes_narrow(const uint32_t *slot, uint32_t number,
                                                          uint32_t bits)
{
    const __m128i above = _mm_set1_epi32((int)~number), wanted = _mm_set1_epi32((int)bits);
    __m128i alike[4], free[4];
    for (int k = 0; k < 4; k++) {
        const __m128i its = _mm_loadu_si128((const __m128i *)(const void *)(slot + 4 * k));
        alike[k] = _mm_cmpeq_epi32(_mm_and_si128(its, above), wanted);
        free[k] = _mm_cmpeq_epi32(its, _mm_setzero_si128());
    }
    const uint32_t none = rmap_key_lanes_bits(free);
    return (struct rmap_key_lanes){rmap_key_lanes_bits(alike) & ~none, none};
}
#else
#define RMAP_KEY_LANES_WIDE

static inline bool rmap_key_lanes_are_wide(void)
{
    return false;
}

static inline struct rmap_key_lanes rmap_key_lanes_narrow(const uint32_t *slot, uint32_t number,
                                                          uint32_t bits)
{
    struct rmap_key_lanes lanes = {0, 0};
    for (uint32_t k = 0; k < RMAP_KEY_SLOTS_TOGETHER; k++) {
        lanes.alike |= (uint32_t)(slot[k] != 0 && (slot[k] & ~number) == bits) << k;
        lanes.free |= (uint32_t)(slot[k] == 0) << k;
    }
    return lanes;
}

static inline struct rmap_key_lanes rmap_key_lanes_wide(const uint32_t *slot, uint32_t number,
                                                        uint32_t bits)
{
    return rmap_key_lanes_narrow(slot, number, bits);
}
#endif

/* Which of the slots have the index in bits `number`, and `bits` above it. is_wide: a constant, in
 * a function that is RMAP_KEY_LANES_WIDE. */
RMAP_COPIED struct rmap_key_lanes rmap_key_lanes_of(const uint32_t *slot, uint32_t number,
                                                    uint32_t bits, bool is_wide)
{
    return is_wide ? rmap_key_lanes_wide(slot, number, bits)
                   : rmap_key_lanes_narrow(slot, number, bits);
}

#endif
