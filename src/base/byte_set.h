/* SPDX-License-Identifier: MIT
 *
 * Bytes and numbers tested against sets, and what passed as bits, counted in groups of consecutive
 * ones.
 */
#ifndef RMAP_BYTE_SET_H
#define RMAP_BYTE_SET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Bit i % 64 of bits[i / 64] says whether byte i is one of some [n_some]; the last word has 0
 * behind it. */
void rmap_bytes_among(const uint8_t *byte, size_t n, const uint8_t *some, size_t n_some,
                      uint64_t *bits);

/* flag[i]: member[byte[i]]; flag may be `byte`. */
void rmap_byte_set_flags(const uint8_t *byte, size_t n, const uint8_t member[256], uint8_t *flag);

/* Bits as above of numbers [n] with low <= number < low + span, 32 bits throughout. */
void rmap_range_bits(const int32_t *number, size_t n, uint32_t low, uint32_t span, uint64_t *bits);

/* Bits stay set where a word [n] has one of the bits `any`; where it has none of the bits `none`.
 */
void rmap_keep_any_bits(const uint32_t *word, size_t n, uint32_t any, uint64_t *bits);
void rmap_keep_none_bits(const uint32_t *word, size_t n, uint32_t none, uint64_t *bits);

/* Words of a bit for each of n. */
static inline size_t rmap_bit_words(size_t n)
{
    return (n + 63) / 64;
}

/* Eight bytes from any byte on hold so many bits from any bit of it on. */
enum { RMAP_BITS_READ = 57 };

/* Which of n < 2^32 bytes are that one, ascending: at [as many]. Returns how many. */
size_t rmap_bytes_list(const uint8_t *byte, size_t n, uint8_t which, uint32_t *at);

/* How many of n <= RMAP_BITS_READ bits from `first` on are 1. One word more is read. */
static inline uint32_t rmap_bits_count_few(const uint64_t *bits, uint64_t first, uint32_t n)
{
    uint64_t word;
    memcpy(&word, (const char *)bits + first / 8, sizeof word);
    return (uint32_t)__builtin_popcountll(word >> first % 8 & ((UINT64_C(1) << n) - 1));
}

/* Of any n bits. */
static inline uint32_t rmap_bits_count(const uint64_t *bits, uint64_t first, uint32_t n)
{
    uint32_t sum = 0;
    for (; __builtin_expect(n > RMAP_BITS_READ, 0); n -= RMAP_BITS_READ, first += RMAP_BITS_READ)
        sum += rmap_bits_count_few(bits, first, RMAP_BITS_READ);
    return sum + rmap_bits_count_few(bits, first, n);
}

/* Groups that follow each other from bit 0 on, of size [n_group] bits each, as the rows of rays
 * are; one word more is read. How many bits of each are 1: count [n_group]; a bit for each of which
 * one is 1, of which the last is 1: out [words of n_group]. */
void rmap_bits_count_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                            uint32_t *count);
void rmap_bits_any_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                          uint64_t *out);
void rmap_bits_last_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                           uint64_t *out);

#endif
