/* SPDX-License-Identifier: MIT
 *
 * Elements are taken as whole words and narrowed, which compilers turn into vector packs and
 * unpacks; byte-wise loops with a stride they do not.
 */
#include "io/codec/shuffle.h"

#include <string.h>

#include "base/wide.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "columns are little-endian in memory");

RMAP_WIDE
static void shuffle2(const uint16_t *restrict e, size_t n, uint8_t *restrict p0,
                     uint8_t *restrict p1)
{
    for (size_t i = 0; i < n; i++) {
        p0[i] = (uint8_t)(e[i] & 255);
        p1[i] = (uint8_t)(e[i] >> 8);
    }
}

RMAP_WIDE
static void shuffle4(const uint32_t *restrict e, size_t n, uint8_t *restrict p0,
                     uint8_t *restrict p1, uint8_t *restrict p2, uint8_t *restrict p3)
{
    for (size_t i = 0; i < n; i++) {
        p0[i] = (uint8_t)(e[i] & 255);
        p1[i] = (uint8_t)(e[i] >> 8 & 255);
        p2[i] = (uint8_t)(e[i] >> 16 & 255);
        p3[i] = (uint8_t)(e[i] >> 24);
    }
}

/* Sixteen bytes of two planes become pairs; pairs of pairs, and so on. */
typedef uint8_t bytes __attribute__((vector_size(16)));
#if defined(__clang__)
#define MIX(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define MIX(a, b, ...) __builtin_shuffle(a, b, (bytes){__VA_ARGS__})
#endif

static inline bytes get(const uint8_t *p)
{
    bytes b;
    memcpy(&b, p, sizeof b);
    return b;
}

static inline void put(void *p, bytes b)
{
    memcpy(p, &b, sizeof b);
}

static inline bytes pair_low(bytes a, bytes b)
{
    return MIX(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}

static inline bytes pair_high(bytes a, bytes b)
{
    return MIX(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
}

static inline bytes pair2_low(bytes a, bytes b)
{
    return MIX(a, b, 0, 1, 16, 17, 2, 3, 18, 19, 4, 5, 20, 21, 6, 7, 22, 23);
}

static inline bytes pair2_high(bytes a, bytes b)
{
    return MIX(a, b, 8, 9, 24, 25, 10, 11, 26, 27, 12, 13, 28, 29, 14, 15, 30, 31);
}

static void unshuffle2(const uint8_t *restrict p0, const uint8_t *restrict p1, size_t n,
                       uint16_t *restrict e)
{
    size_t i = 0;
    for (; n - i >= 16; i += 16) {
        bytes a = get(p0 + i), b = get(p1 + i);
        put(e + i, pair_low(a, b));
        put(e + i + 8, pair_high(a, b));
    }
    for (; i < n; i++)
        e[i] = (uint16_t)(p0[i] | p1[i] << 8);
}

static void unshuffle4(const uint8_t *restrict p0, const uint8_t *restrict p1,
                       const uint8_t *restrict p2, const uint8_t *restrict p3, size_t n,
                       uint32_t *restrict e)
{
    size_t i = 0;
    for (; n - i >= 16; i += 16) {
        bytes a = get(p0 + i), b = get(p1 + i), c = get(p2 + i), d = get(p3 + i);
        bytes low = pair_low(a, b), high = pair_high(a, b);
        bytes low2 = pair_low(c, d), high2 = pair_high(c, d);
        put(e + i, pair2_low(low, low2));
        put(e + i + 4, pair2_high(low, low2));
        put(e + i + 8, pair2_low(high, high2));
        put(e + i + 12, pair2_high(high, high2));
    }
    for (; i < n; i++)
        e[i] =
            (uint32_t)p0[i] | (uint32_t)p1[i] << 8 | (uint32_t)p2[i] << 16 | (uint32_t)p3[i] << 24;
}

/* Eight-byte elements go through their halves, a cache-sized strip at a time. */
#define STRIP 1024

RMAP_WIDE
static void shuffle8(const uint64_t *restrict e, size_t n, uint8_t *restrict plane, size_t stride)
{
    uint32_t low[STRIP], high[STRIP];
    for (size_t i = 0; i < n; i += STRIP) {
        size_t m = n - i < STRIP ? n - i : STRIP;
        for (size_t k = 0; k < m; k++) {
            low[k] = (uint32_t)(e[i + k] & UINT32_MAX);
            high[k] = (uint32_t)(e[i + k] >> 32);
        }
        uint8_t *p = plane + i;
        shuffle4(low, m, p, p + stride, p + 2 * stride, p + 3 * stride);
        p += 4 * stride;
        shuffle4(high, m, p, p + stride, p + 2 * stride, p + 3 * stride);
    }
}

static void unshuffle8(const uint8_t *restrict plane, size_t stride, size_t n, uint64_t *restrict e)
{
    uint32_t low[STRIP], high[STRIP];
    for (size_t i = 0; i < n; i += STRIP) {
        size_t m = n - i < STRIP ? n - i : STRIP;
        const uint8_t *p = plane + i, *q = p + 4 * stride;
        unshuffle4(p, p + stride, p + 2 * stride, p + 3 * stride, m, low);
        unshuffle4(q, q + stride, q + 2 * stride, q + 3 * stride, m, high);
        for (size_t k = 0; k < m; k++)
            e[i + k] = (uint64_t)high[k] << 32 | low[k];
    }
}

void rmap_shuffle(const void *element, size_t n, size_t element_nbytes, uint8_t *plane,
                  size_t stride)
{
    uint8_t *p = plane;
    if (element_nbytes == 2)
        shuffle2(element, n, p, p + stride);
    else if (element_nbytes == 4)
        shuffle4(element, n, p, p + stride, p + 2 * stride, p + 3 * stride);
    else if (element_nbytes == 8)
        shuffle8(element, n, p, stride);
    else if (n > 0)
        memcpy(plane, element, n);
}

void rmap_unshuffle(const uint8_t *plane, size_t n, size_t first, size_t n_range,
                    size_t element_nbytes, void *element)
{
    const uint8_t *p = plane + first;
    if (element_nbytes == 2)
        unshuffle2(p, p + n, n_range, element);
    else if (element_nbytes == 4)
        unshuffle4(p, p + n, p + 2 * n, p + 3 * n, n_range, element);
    else if (element_nbytes == 8)
        unshuffle8(p, n, n_range, element);
    else
        memcpy(element, p, n_range);
}
