/* SPDX-License-Identifier: MIT */
#include "base/bit_bytes.h"

#include <string.h>

#include "base/intrinsics.h"

/* Eight bits as eight bytes of 0 or 255. */
static inline uint64_t widen(uint64_t bits)
{
    uint64_t each = (bits & 255) * UINT64_C(0x0101010101010101) & UINT64_C(0x8040201008040201);
    uint64_t one = (each + UINT64_C(0x7f7f7f7f7f7f7f7f)) >> 7 & UINT64_C(0x0101010101010101);
    return one * 255;
}

static void plain_bytes(const uint64_t *bits, size_t first, size_t n, uint8_t is, uint8_t other,
                        uint8_t *byte)
{
    const uint64_t no = other * UINT64_C(0x0101010101010101);
    const uint64_t change = (uint8_t)(is ^ other) * UINT64_C(0x0101010101010101);
    size_t i = first;
    for (; i + 8 <= n; i += 8) {
        uint64_t eight = (widen(bits[i / 64] >> i % 64) & change) ^ no;
        memcpy(byte + i, &eight, sizeof eight);
    }
    for (; i < n; i++)
        byte[i] = bits[i / 64] >> i % 64 & 1 ? is : other;
}

#ifdef RMAP_INTRINSICS
/* 32 at a time: each byte gets the byte that its bit is in, and keeps that bit. */
__attribute__((target("avx2"))) static size_t wide_bytes(const uint64_t *bits, size_t n, uint8_t is,
                                                         uint8_t other, uint8_t *byte)
{
    const __m256i own = _mm256_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2,
                                         2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3);
    const __m256i bit = _mm256_set1_epi64x((long long)UINT64_C(0x8040201008040201));
    const __m256i yes = _mm256_set1_epi8((char)is), no = _mm256_set1_epi8((char)other);
    size_t i = 0;
    for (; i + 32 <= n; i += 32) {
        __m256i four = _mm256_set1_epi32((int)(uint32_t)(bits[i / 64] >> i % 64));
        __m256i each = _mm256_and_si256(_mm256_shuffle_epi8(four, own), bit);
        each = _mm256_cmpeq_epi8(each, bit);
        _mm256_storeu_si256((void *)(byte + i), _mm256_blendv_epi8(no, yes, each));
    }
    return i;
}

static size_t vector_bytes(const uint64_t *bits, size_t n, uint8_t is, uint8_t other, uint8_t *byte)
{
    return __builtin_cpu_supports("avx2") ? wide_bytes(bits, n, is, other, byte) : 0;
}
#else
static size_t vector_bytes(const uint64_t *bits, size_t n, uint8_t is, uint8_t other, uint8_t *byte)
{
    (void)bits;
    (void)n;
    (void)is;
    (void)other;
    (void)byte;
    return 0;
}
#endif

void rmap_bits_to_bytes(const uint64_t *bits, size_t n, uint8_t is, uint8_t other, uint8_t *byte)
{
    plain_bytes(bits, vector_bytes(bits, n, is, other, byte), n, is, other, byte);
}
