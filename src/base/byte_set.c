/* SPDX-License-Identifier: MIT
 *
 * Bits, bytes and numbers, one made of the other: plain loops, which the compiler widens where it
 * can.
 */
#include "base/byte_set.h"

#include "base/count.h"
#include "base/wide.h"

/* Bit k of the word is byte k, 0 or 1, of 64. */
static inline uint64_t pack(const uint8_t *flag)
{
    uint64_t word = 0, eight;
    for (size_t k = 0; k < 64; k += 8) { /* flag j goes to bit 56 + j, and nothing else there */
        memcpy(&eight, flag + k, sizeof eight);
        word |= (eight * UINT64_C(0x0102040810204080) >> 56) << k;
    }
    return word;
}

/* Few are compared with one by one, many looked up. */
RMAP_WIDE void rmap_bytes_among(const uint8_t *byte, size_t n, const uint8_t *some, size_t n_some,
                                uint64_t *bits)
{
    enum { FEW = 24 };
    uint8_t member[256] = {0}, last[64] = {0};
    for (size_t m = 0; m < n_some; m++)
        member[some[m]] = 1;
    for (size_t i = 0; i < n; i += 64) {
        const uint8_t *at = byte + i;
        uint8_t flag[64] = {0};
        if (n - i < 64)
            at = memcpy(last, at, n - i);
        if (n_some > FEW)
            rmap_byte_set_flags(at, 64, member, flag);
        for (size_t m = 0; n_some <= FEW && m < n_some; m++)
            for (size_t k = 0; k < 64; k++)
                flag[k] |= at[k] == some[m];
        bits[i / 64] = pack(flag);
    }
    if (n % 64 > 0)
        bits[n / 64] &= ~(UINT64_MAX << n % 64);
}

void rmap_byte_set_flags(const uint8_t *byte, size_t n, const uint8_t member[256], uint8_t *flag)
{
    for (size_t i = 0; i < n; i++)
        flag[i] = member[byte[i]];
}

RMAP_WIDE void rmap_range_bits(const int32_t *number, size_t n, uint32_t low, uint32_t span,
                               uint64_t *bits)
{
    for (size_t i = 0; i < n; i += 64) {
        uint64_t word = 0;
        size_t few = n - i < 64 ? n - i : 64;
        for (size_t k = 0; k < few; k++)
            word |= (uint64_t)((uint32_t)number[i + k] - low < span) << k;
        bits[i / 64] = word;
    }
}

/* is: 1 to keep words with one of the bits `which`, 0 those with none. */
RMAP_WIDE static void keep_words(const uint32_t *word, size_t n, uint32_t which, unsigned is,
                                 uint64_t *bits)
{
    for (size_t i = 0; i < n; i += 64) {
        uint64_t keep = 0;
        size_t few = n - i < 64 ? n - i : 64;
        for (size_t k = 0; k < few; k++)
            keep |= (uint64_t)(((word[i + k] & which) != 0) == is) << k;
        bits[i / 64] &= keep | (few < 64 ? UINT64_MAX << few : 0);
    }
}

void rmap_keep_any_bits(const uint32_t *word, size_t n, uint32_t any, uint64_t *bits)
{
    keep_words(word, n, any, 1, bits);
}

void rmap_keep_none_bits(const uint32_t *word, size_t n, uint32_t none, uint64_t *bits)
{
    keep_words(word, n, none, 0, bits);
}

size_t rmap_bytes_list(const uint8_t *byte, size_t n, uint8_t which, uint32_t *at)
{
    uint64_t bits[64];
    const size_t strip = 64 * RMAP_COUNT(bits);
    size_t k = 0;
    for (size_t from = 0; from < n; from += strip) {
        const size_t few = n - from < strip ? n - from : strip;
        rmap_bytes_among(byte + from, few, &which, 1, bits);
        for (size_t w = 0; w < rmap_bit_words(few); w++)
            for (uint64_t left = bits[w]; left; left &= left - 1)
                at[k++] = (uint32_t)(from + 64 * w + (size_t)__builtin_ctzll(left));
    }
    return k;
}

RMAP_WIDE void rmap_bits_count_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                                      uint32_t *count)
{
    uint64_t first = 0;
    for (size_t i = 0; i < n_group; i++) {
        count[i] = rmap_bits_count(bits, first, size[i]);
        first += size[i];
    }
}

RMAP_WIDE void rmap_bits_any_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                                    uint64_t *out)
{
    uint64_t first = 0;
    for (size_t i = 0; i < n_group; i++) {
        uint64_t any = rmap_bits_count(bits, first, size[i]) > 0;
        out[i / 64] = i % 64 == 0 ? any : out[i / 64] | any << i % 64;
        first += size[i];
    }
}

void rmap_bits_last_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                           uint64_t *out)
{
    uint64_t end = 0;
    for (size_t i = 0; i < n_group; i++) {
        end += size[i];
        uint64_t last = size[i] > 0 ? bits[(end - 1) / 64] >> (end - 1) % 64 & 1 : 0;
        out[i / 64] = i % 64 == 0 ? last : out[i / 64] | last << i % 64;
    }
}
