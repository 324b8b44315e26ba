/* SPDX-License-Identifier: MIT */
#include "base/byte_set.h"

#include "base/intrinsics.h"
#include "base/wide.h"

static inline uint64_t pack_bits(const uint8_t *byte, size_t n, const uint8_t member[256])
{
    uint64_t bits = 0;
    for (size_t i = 0; i < n; i++)
        bits |= (uint64_t)member[byte[i]] << i;
    return bits;
}

static void plain_bits(const uint8_t *byte, size_t first, size_t n, const uint8_t member[256],
                       uint64_t *bits)
{
    for (size_t i = first; i < n; i += 64)
        bits[i / 64] = pack_bits(byte + i, n - i < 64 ? n - i : 64, member);
}

/* From a multiple of 64 on. */
static void plain_sets(const uint8_t *byte, size_t first, size_t n, const uint8_t sets[256],
                       unsigned n_set, uint64_t *const *bits)
{
    for (size_t i = first; i < n; i += 64)
        for (unsigned s = 0; s < n_set; s++) {
            uint64_t word = 0;
            for (size_t k = i; k < n && k < i + 64; k++)
                word |= (uint64_t)(sets[byte[k]] >> s & 1) << k % 64;
            bits[s][i / 64] = word;
        }
}

static void plain_flags(const uint8_t *byte, size_t first, size_t n, const uint8_t member[256],
                        uint8_t *flag)
{
    for (size_t i = first; i < n; i++)
        flag[i] = member[byte[i]];
}

static void plain_range(const int32_t *number, size_t first, size_t n, uint32_t low, uint32_t span,
                        uint64_t *bits)
{
    for (size_t i = first; i < n; i++) {
        uint64_t is = (uint32_t)number[i] - low < span;
        bits[i / 64] = i % 64 == 0 ? is : bits[i / 64] | is << i % 64;
    }
}

/* flip: all ones to keep words with one of the bits `which`, 0 those with none. */
static void plain_words(const uint32_t *word, size_t first, size_t n, uint32_t which, uint64_t flip,
                        uint64_t *bits)
{
    for (size_t i = first; i < n; i++)
        bits[i / 64] &= ~(((uint64_t)((word[i] & which) != 0) ^ (flip & 1)) << i % 64);
}

#ifdef RMAP_INTRINSICS
/* 32 numbers as 32 bytes, all ones or all zeros, in their order: packing keeps to halves. */
__attribute__((target("avx2"))) static inline uint64_t bits_of(__m256i a, __m256i b, __m256i c,
                                                               __m256i d)
{
    const __m256i order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    __m256i byte = _mm256_packs_epi16(_mm256_packs_epi32(a, b), _mm256_packs_epi32(c, d));
    return (uint32_t)_mm256_movemask_epi8(_mm256_permutevar8x32_epi32(byte, order));
}

__attribute__((target("avx2"))) static inline __m256i load_8(const void *number)
{
    return _mm256_loadu_si256(number);
}

/* low <= number < low + span, as number - low <= span - 1 */
__attribute__((target("avx2"))) static inline __m256i in_range(const int32_t *number, __m256i low,
                                                               __m256i last)
{
    __m256i at = _mm256_sub_epi32(load_8(number), low);
    return _mm256_cmpeq_epi32(_mm256_min_epu32(at, last), at);
}

__attribute__((target("avx2"))) static size_t
wide_range(const int32_t *number, size_t n, uint32_t low, uint32_t span, uint64_t *bits)
{
    const __m256i from = _mm256_set1_epi32((int)low), last = _mm256_set1_epi32((int)(span - 1));
    size_t i = 0;
    for (; i + 64 <= n; i += 64) {
        uint64_t half[2];
        for (int k = 0; k < 2; k++) {
            const int32_t *at = number + i + 32 * k;
            half[k] = bits_of(in_range(at, from, last), in_range(at + 8, from, last),
                              in_range(at + 16, from, last), in_range(at + 24, from, last));
        }
        bits[i / 64] = half[0] | half[1] << 32;
    }
    return i;
}

__attribute__((target("avx2"))) static inline __m256i has_none(const uint32_t *word, __m256i any)
{
    return _mm256_cmpeq_epi32(_mm256_and_si256(load_8(word), any), _mm256_setzero_si256());
}

__attribute__((target("avx2"))) static size_t
wide_words(const uint32_t *word, size_t n, uint32_t which, uint64_t flip, uint64_t *bits)
{
    const __m256i all = _mm256_set1_epi32((int)which);
    size_t i = 0;
    for (; i + 64 <= n; i += 64) {
        uint64_t half[2];
        for (int k = 0; k < 2; k++) {
            const uint32_t *at = word + i + 32 * k;
            half[k] = bits_of(has_none(at, all), has_none(at + 8, all), has_none(at + 16, all),
                              has_none(at + 24, all));
        }
        bits[i / 64] &= (half[0] | half[1] << 32) ^ flip;
    }
    return i;
}

/* A set of bytes as two tables by the low half of the byte: bit h of an entry stands for the high
 * half h (and h + 8). */
struct nibbles {
    __m256i low, high;
};

__attribute__((target("avx2"))) static struct nibbles nibbles_of(const uint8_t member[256])
{
    uint8_t table[2][32] = {{0}};
    for (unsigned c = 0; c < 256; c++)
        if (member[c])
            table[c >> 7][c & 15] |= (uint8_t)(1u << (c >> 4 & 7));
    memcpy(table[0] + 16, table[0], 16);
    memcpy(table[1] + 16, table[1], 16);
    return (struct nibbles){_mm256_loadu_si256((const void *)table[0]),
                            _mm256_loadu_si256((const void *)table[1])};
}

/* 32 bytes as what sets are asked with. */
struct places {
    __m256i byte, low, bit;
};

__attribute__((target("avx2"))) static inline struct places places_of(const uint8_t *byte)
{
    const __m256i power = _mm256_set1_epi64x((long long)UINT64_C(0x8040201008040201));
    const __m256i half = _mm256_set1_epi8(15);
    __m256i c = _mm256_loadu_si256((const void *)byte);
    __m256i high = _mm256_and_si256(_mm256_srli_epi16(c, 4), half);
    return (struct places){c, _mm256_and_si256(c, half), _mm256_shuffle_epi8(power, high)};
}

/* All ones where a byte is of the set. */
__attribute__((target("avx2"))) static inline __m256i test_places(const struct places *at,
                                                                  const struct nibbles *set)
{
    __m256i row = _mm256_blendv_epi8(_mm256_shuffle_epi8(set->low, at->low),
                                     _mm256_shuffle_epi8(set->high, at->low), at->byte);
    return _mm256_cmpeq_epi8(_mm256_and_si256(row, at->bit), at->bit);
}

__attribute__((target("avx2"))) static inline __m256i test_32(const uint8_t *byte,
                                                              const struct nibbles *set)
{
    const struct places at = places_of(byte);
    return test_places(&at, set);
}

__attribute__((target("avx2"))) static void wide_bits(const uint8_t *byte, size_t n,
                                                      const uint8_t member[256], uint64_t *bits)
{
    const struct nibbles set = nibbles_of(member);
    size_t i = 0;
    for (; i + 64 <= n; i += 64)
        bits[i / 64] = (uint32_t)_mm256_movemask_epi8(test_32(byte + i, &set)) |
                       (uint64_t)(uint32_t)_mm256_movemask_epi8(test_32(byte + i + 32, &set)) << 32;
    plain_bits(byte, i, n, member, bits);
}

__attribute__((target("avx2"))) static void wide_flags(const uint8_t *byte, size_t n,
                                                       const uint8_t member[256], uint8_t *flag)
{
    const struct nibbles set = nibbles_of(member);
    const __m256i one = _mm256_set1_epi8(1);
    size_t i = 0;
    for (; i + 32 <= n; i += 32)
        _mm256_storeu_si256((void *)(flag + i), _mm256_and_si256(test_32(byte + i, &set), one));
    plain_flags(byte, i, n, member, flag);
}

/* 8 x 8 bits: bit c of byte r changes places with bit r of byte c (Warren, Hacker's Delight, 7-3).
 */
static inline uint64_t transpose(uint64_t x)
{
    uint64_t t = (x ^ x >> 7) & UINT64_C(0x00aa00aa00aa00aa);
    x ^= t ^ t << 7;
    t = (x ^ x >> 14) & UINT64_C(0x0000cccc0000cccc);
    x ^= t ^ t << 14;
    t = (x ^ x >> 28) & UINT64_C(0x00000000f0f0f0f0);
    return x ^ t ^ t << 28;
}

/* As nibbles_of, of each set. */
__attribute__((target("avx2"))) static void nibbles_of_sets(const uint8_t sets[256],
                                                            struct nibbles out[8])
{
    uint8_t table[8][2][16];
    for (unsigned k = 0; k < 32; k++) {
        uint64_t of_high = 0;
        for (unsigned h = 0; h < 8; h++)
            of_high |= (uint64_t)sets[(k & 16) << 3 | h << 4 | (k & 15)] << 8 * h;
        of_high = transpose(of_high);
        for (unsigned s = 0; s < 8; s++)
            table[s][k >> 4][k & 15] = (uint8_t)(of_high >> 8 * s);
    }
    for (unsigned s = 0; s < 8; s++) {
        __m128i low = _mm_loadu_si128((const void *)table[s][0]);
        __m128i high = _mm_loadu_si128((const void *)table[s][1]);
        out[s] =
            (struct nibbles){_mm256_broadcastsi128_si256(low), _mm256_broadcastsi128_si256(high)};
    }
}

/* So many sets' tables, and what is at hand of the bytes, stay in registers. */
enum { SETS_AT_ONCE = 4 };

/* n: a multiple of 64; n_set <= SETS_AT_ONCE, known where this is copied to. */
__attribute__((target("avx2"))) RMAP_COPIED void test_sets(const uint8_t *byte, size_t n,
                                                           const struct nibbles *set,
                                                           unsigned n_set, uint64_t *const *bits)
{
    for (size_t i = 0; i < n; i += 64) {
        const struct places first = places_of(byte + i), second = places_of(byte + i + 32);
        RMAP_UNROLL
        for (unsigned s = 0; s < n_set; s++) {
            uint32_t low = (uint32_t)_mm256_movemask_epi8(test_places(&first, &set[s]));
            uint32_t high = (uint32_t)_mm256_movemask_epi8(test_places(&second, &set[s]));
            bits[s][i / 64] = low | (uint64_t)high << 32;
        }
    }
}

__attribute__((target("avx2"))) static void wide_sets(const uint8_t *byte, size_t n,
                                                      const uint8_t sets[256], unsigned n_set,
                                                      uint64_t *const *bits)
{
    struct nibbles set[8];
    const size_t whole = n / 64 * 64;
    nibbles_of_sets(sets, set);
    for (unsigned s = 0; s < n_set; s += SETS_AT_ONCE)
        switch (n_set - s) {
        case 1:
            test_sets(byte, whole, set + s, 1, bits + s);
            break;
        case 2:
            test_sets(byte, whole, set + s, 2, bits + s);
            break;
        case 3:
            test_sets(byte, whole, set + s, 3, bits + s);
            break;
        default:
            test_sets(byte, whole, set + s, SETS_AT_ONCE, bits + s);
        }
    plain_sets(byte, whole, n, sets, n_set, bits);
}

__attribute__((target("avx2,bmi,bmi2,popcnt"))) static void
wide_count(const uint64_t *restrict bits, const uint32_t *restrict size, size_t n_group,
           uint32_t *restrict count)
{
    uint64_t first = 0;
    for (size_t i = 0; i < n_group; i++) {
        count[i] = rmap_bits_count(bits, first, size[i]);
        first += size[i];
    }
}

static int is_wide(void)
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") &&
           __builtin_cpu_supports("popcnt");
}
#else
static void wide_bits(const uint8_t *byte, size_t n, const uint8_t member[256], uint64_t *bits)
{
    plain_bits(byte, 0, n, member, bits);
}

static void wide_sets(const uint8_t *byte, size_t n, const uint8_t sets[256], unsigned n_set,
                      uint64_t *const *bits)
{
    plain_sets(byte, 0, n, sets, n_set, bits);
}

static void wide_flags(const uint8_t *byte, size_t n, const uint8_t member[256], uint8_t *flag)
{
    plain_flags(byte, 0, n, member, flag);
}

static size_t wide_range(const int32_t *number, size_t n, uint32_t low, uint32_t span,
                         uint64_t *bits)
{
    (void)number;
    (void)n;
    (void)low;
    (void)span;
    (void)bits;
    return 0;
}

static size_t wide_words(const uint32_t *word, size_t n, uint32_t which, uint64_t flip,
                         uint64_t *bits)
{
    (void)word;
    (void)n;
    (void)which;
    (void)flip;
    (void)bits;
    return 0;
}

static void wide_count(const uint64_t *bits, const uint32_t *size, size_t n_group, uint32_t *count)
{
    (void)bits;
    (void)size;
    (void)n_group;
    (void)count;
}

static int is_wide(void)
{
    return 0;
}
#endif

void rmap_byte_set_bits(const uint8_t *byte, size_t n, const uint8_t member[256], uint64_t *bits)
{
    if (is_wide())
        wide_bits(byte, n, member, bits);
    else
        plain_bits(byte, 0, n, member, bits);
}

void rmap_byte_sets_bits(const uint8_t *byte, size_t n, const uint8_t sets[256], unsigned n_set,
                         uint64_t *const *bits)
{
    if (is_wide())
        wide_sets(byte, n, sets, n_set, bits);
    else
        plain_sets(byte, 0, n, sets, n_set, bits);
}

void rmap_byte_set_flags(const uint8_t *byte, size_t n, const uint8_t member[256], uint8_t *flag)
{
    if (is_wide())
        wide_flags(byte, n, member, flag);
    else
        plain_flags(byte, 0, n, member, flag);
}

void rmap_range_bits(const int32_t *number, size_t n, uint32_t low, uint32_t span, uint64_t *bits)
{
    size_t first = is_wide() && span > 0 ? wide_range(number, n, low, span, bits) : 0;
    plain_range(number, first, n, low, span, bits);
}

static void keep_words(const uint32_t *word, size_t n, uint32_t which, uint64_t flip,
                       uint64_t *bits)
{
    size_t first = is_wide() ? wide_words(word, n, which, flip, bits) : 0;
    plain_words(word, first, n, which, flip, bits);
}

void rmap_keep_any_bits(const uint32_t *word, size_t n, uint32_t any, uint64_t *bits)
{
    keep_words(word, n, any, UINT64_MAX, bits);
}

void rmap_keep_none_bits(const uint32_t *word, size_t n, uint32_t none, uint64_t *bits)
{
    keep_words(word, n, none, 0, bits);
}

void rmap_bits_count_groups(const uint64_t *bits, const uint32_t *size, size_t n_group,
                            uint32_t *count)
{
    uint64_t first = 0;
    if (is_wide()) {
        wide_count(bits, size, n_group, count);
        return;
    }
    for (size_t i = 0; i < n_group; i++) {
        count[i] = rmap_bits_count(bits, first, size[i]);
        first += size[i];
    }
}
