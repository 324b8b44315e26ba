/* SPDX-License-Identifier: MIT */
#include "io/codec/huffman_wide.h"

#include "base/intrinsics.h"

#ifdef RMAP_INTRINSICS
#define WIDE   __attribute__((target("avx512f,avx512bw,avx512vbmi,bmi2")))
#define INLINE static inline __attribute__((always_inline)) WIDE

enum { AT_ONCE = 64, FOURS = AT_ONCE / 4 };

/* A table of 256 bytes in four registers. */
struct table {
    __m512i quarter[4];
};

INLINE struct table load_table(const uint8_t byte[256])
{
    struct table table;
    for (int i = 0; i < 4; i++)
        table.quarter[i] = _mm512_loadu_si512(byte + 64 * i);
    return table;
}

INLINE __m512i look_up(const struct table *table, __m512i index)
{
    __m512i low = _mm512_permutex2var_epi8(table->quarter[0], index, table->quarter[1]);
    __m512i high = _mm512_permutex2var_epi8(table->quarter[2], index, table->quarter[3]);
    return _mm512_mask_blend_epi8(_mm512_movepi8_mask(index), low, high);
}

/* Codes one behind the other, and their lengths. */
struct codes {
    __m512i value, length;
};

/* Of 16 bits each to 32. */
INLINE struct codes join_pairs(struct codes c)
{
    const __m512i first = _mm512_set1_epi32(0xffff);
    __m512i n = _mm512_and_si512(c.length, first);
    __m512i next = _mm512_sllv_epi32(_mm512_srli_epi32(c.value, 16), n);
    return (struct codes){_mm512_or_si512(_mm512_and_si512(c.value, first), next),
                          _mm512_add_epi32(n, _mm512_srli_epi32(c.length, 16))};
}

/* Of 32 to 64. */
INLINE struct codes join_fours(struct codes c)
{
    const __m512i first = _mm512_set1_epi64(0xffffffff);
    __m512i n = _mm512_and_si512(c.length, first);
    __m512i next = _mm512_sllv_epi64(_mm512_srli_epi64(c.value, 32), n);
    return (struct codes){_mm512_or_si512(_mm512_and_si512(c.value, first), next),
                          _mm512_add_epi64(n, _mm512_srli_epi64(c.length, 32))};
}

/* Two registers of eight, of which each keeps to its quarters, in the order of the bytes. */
INLINE void store_fours(__m512i low, __m512i high, uint64_t out[FOURS])
{
    const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    _mm512_storeu_si512(out, _mm512_permutex2var_epi64(low, first, high));
    _mm512_storeu_si512(out + FOURS / 2, _mm512_permutex2var_epi64(low, second, high));
}

WIDE static void put_all(const uint8_t table[3][256], const uint8_t *data, size_t n,
                         struct rmap_bits *bits)
{
    const struct table length = load_table(table[0]), lower = load_table(table[1]),
                       upper = load_table(table[2]);
    const __m512i zero = _mm512_setzero_si512();
    struct rmap_bits local = *bits; /* in registers: `out` may point anywhere */
    uint64_t value[FOURS], n_bit[FOURS];
    for (size_t i = 0; i < n; i += AT_ONCE) {
        __m512i byte = _mm512_loadu_si512(data + i), a = look_up(&lower, byte);
        __m512i b = look_up(&upper, byte), l = look_up(&length, byte);
        struct codes low = {_mm512_unpacklo_epi8(a, b), _mm512_unpacklo_epi8(l, zero)};
        struct codes high = {_mm512_unpackhi_epi8(a, b), _mm512_unpackhi_epi8(l, zero)};
        low = join_fours(join_pairs(low));
        high = join_fours(join_pairs(high));
        store_fours(low.value, high.value, value);
        store_fours(low.length, high.length, n_bit);
        for (int k = 0; k < FOURS; k++)
            rmap_bits_put(&local, value[k], (unsigned)n_bit[k]);
    }
    *bits = local;
}

size_t rmap_huffman_wide(const uint32_t value[256], const uint32_t length[256], const uint8_t *data,
                         size_t n, struct rmap_bits *bits)
{
    uint8_t table[3][256];
    if (n < AT_ONCE || !__builtin_cpu_supports("avx512vbmi") ||
        !__builtin_cpu_supports("avx512bw") || !__builtin_cpu_supports("bmi2"))
        return 0;
    for (int i = 0; i < 256; i++) {
        table[0][i] = (uint8_t)length[i];
        table[1][i] = (uint8_t)(value[i] & 255);
        table[2][i] = (uint8_t)(value[i] >> 8);
    }
    n -= n % AT_ONCE;
    put_all((const uint8_t(*)[256])table, data, n, bits);
    return n;
}
#else
size_t rmap_huffman_wide(const uint32_t value[256], const uint32_t length[256], const uint8_t *data,
                         size_t n, struct rmap_bits *bits)
{
    (void)value;
    (void)length;
    (void)data;
    (void)n;
    (void)bits;
    return 0;
}
#endif
