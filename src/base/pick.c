/* SPDX-License-Identifier: MIT */
#include "base/pick.h"

#include <stdbool.h>
#include <string.h>

#include "base/intrinsics.h"
#include "base/wide.h"

RMAP_WIDE size_t rmap_pick_count(const uint8_t *match, size_t n)
{
    enum { TOGETHER = 128 }; /* whose sum a byte holds */
    size_t sum = 0;
    for (size_t first = 0; first < n; first += TOGETHER) {
        const size_t end = n - first < TOGETHER ? n : first + TOGETHER;
        uint8_t some = 0;
        for (size_t i = first; i < end; i++)
            some = (uint8_t)(some + match[i]);
        sum += some;
    }
    return sum;
}

#ifdef RMAP_INTRINSICS
enum { WIDTH = 4 };

/* For each set of four doubles: those of it first, by their halves. */
static const uint32_t order[16][2 * WIDTH] = {
    {0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {2, 3, 0, 1, 4, 5, 6, 7},
    {0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 0, 1, 2, 3, 6, 7}, {0, 1, 4, 5, 2, 3, 6, 7},
    {2, 3, 4, 5, 0, 1, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {6, 7, 0, 1, 2, 3, 4, 5},
    {0, 1, 6, 7, 2, 3, 4, 5}, {2, 3, 6, 7, 0, 1, 4, 5}, {0, 1, 2, 3, 6, 7, 4, 5},
    {4, 5, 6, 7, 0, 1, 2, 3}, {0, 1, 4, 5, 6, 7, 2, 3}, {2, 3, 4, 5, 6, 7, 0, 1},
    {0, 1, 2, 3, 4, 5, 6, 7}};

__attribute__((target("avx2,popcnt"))) static inline size_t pick_4(const double *value,
                                                                   uint32_t which, double *to)
{
    const __m256i four = _mm256_loadu_si256((const void *)value);
    const __m256i place = _mm256_loadu_si256((const void *)order[which]);
    _mm256_storeu_si256((void *)to, _mm256_permutevar8x32_epi32(four, place));
    return (size_t)_mm_popcnt_u32(which);
}

/* Bit k: byte k. */
static inline uint32_t bits_of_4(const uint8_t *match)
{
    uint32_t bytes;
    memcpy(&bytes, match, sizeof bytes);
    return (bytes * 0x01020408u) >> 24 & 15;
}

__attribute__((target("avx2,popcnt"))) static inline uint32_t bits_equal_4(const int32_t *of,
                                                                           __m128i wanted)
{
    const __m128i equal = _mm_cmpeq_epi32(_mm_loadu_si128((const void *)of), wanted);
    return (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(equal));
}

/* n: a multiple of WIDTH. */
__attribute__((target("avx2,popcnt"))) static size_t
pick_matching_wide(const double *value, const uint8_t *match, size_t n, double *to)
{
    size_t at = 0;
    for (size_t k = 0; k < n; k += WIDTH)
        at += pick_4(value + k, bits_of_4(match + k), to + at);
    return at;
}

__attribute__((target("avx2,popcnt"))) static size_t
pick_of_wide(const double *value, const int32_t *of, int32_t which, size_t n, double *to)
{
    const __m128i wanted = _mm_set1_epi32(which);
    size_t at = 0;
    for (size_t k = 0; k < n; k += WIDTH)
        at += pick_4(value + k, bits_equal_4(of + k, wanted), to + at);
    return at;
}

__attribute__((target("avx2,popcnt"))) static size_t
pick_matching_of_wide(const double *value, const uint8_t *match, const int32_t *of, int32_t which,
                      size_t n, double *to)
{
    const __m128i wanted = _mm_set1_epi32(which);
    size_t at = 0;
    for (size_t k = 0; k < n; k += WIDTH)
        at += pick_4(value + k, bits_equal_4(of + k, wanted) & bits_of_4(match + k), to + at);
    return at;
}

__attribute__((target("avx2,popcnt"))) static size_t pick_both_wide(const double *value,
                                                                    const int32_t *of,
                                                                    int32_t which, size_t n,
                                                                    double *to, double *others)
{
    const __m128i wanted = _mm_set1_epi32(which);
    size_t at = 0;
    for (size_t k = 0; k < n; k += WIDTH) {
        const uint32_t its = bits_equal_4(of + k, wanted);
        (void)pick_4(value + k, its ^ 15, others + k - at);
        at += pick_4(value + k, its, to + at);
    }
    return at;
}

static size_t wide_part(size_t n)
{
    return __builtin_cpu_supports("avx2") ? n / WIDTH * WIDTH : 0;
}
#else
#define wide_part(n)                                          ((size_t)0)
#define pick_matching_wide(value, match, n, to)               ((size_t)0)
#define pick_of_wide(value, of, which, n, to)                 ((size_t)0)
#define pick_both_wide(value, of, which, n, to, others)       ((size_t)0)
#define pick_matching_of_wide(value, match, of, which, n, to) ((size_t)0)
#endif

size_t rmap_pick_matching(const double *value, const uint8_t *match, size_t n, double *to)
{
    const size_t n_wide = wide_part(n);
    size_t at = n_wide > 0 ? pick_matching_wide(value, match, n_wide, to) : 0;
    for (size_t k = n_wide; k < n; k++) {
        to[at] = value[k];
        at += match[k];
    }
    return at;
}

size_t rmap_pick_of(const double *value, const int32_t *of, int32_t which, size_t n, double *to)
{
    const size_t n_wide = wide_part(n);
    size_t at = n_wide > 0 ? pick_of_wide(value, of, which, n_wide, to) : 0;
    for (size_t k = n_wide; k < n; k++) {
        to[at] = value[k];
        at += of[k] == which;
    }
    return at;
}

/* Puts the first of the others in their places again, which those may have run over. */
static void mend_first(const double *value, const int32_t *of, int32_t which, size_t n,
                       double *others)
{
    for (size_t k = 0, at = 0; k < n && at < RMAP_PICK_MORE; k++)
        if (of[k] != which)
            others[at++] = value[k];
}

size_t rmap_pick_both(const double *value, const int32_t *of, int32_t which, size_t n, double *to,
                      double *others)
{
    const size_t n_wide = wide_part(n);
    size_t at = n_wide > 0 ? pick_both_wide(value, of, which, n_wide, to, others) : 0;
    for (size_t k = n_wide; k < n; k++) {
        const bool its = of[k] == which;
        *(its ? to + at : others + k - at) = value[k];
        at += its;
    }
    mend_first(value, of, which, n, others);
    return at;
}

size_t rmap_pick_matching_of(const double *value, const uint8_t *match, const int32_t *of,
                             int32_t which, size_t n, double *to)
{
    const size_t n_wide = wide_part(n);
    size_t at = n_wide > 0 ? pick_matching_of_wide(value, match, of, which, n_wide, to) : 0;
    for (size_t k = n_wide; k < n; k++) {
        to[at] = value[k];
        at += (of[k] == which) & match[k];
    }
    return at;
}
