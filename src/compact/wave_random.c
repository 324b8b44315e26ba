/* SPDX-License-Identifier: MIT
 *
 * Philox4x32-10 of base/rng.h (Salmon et al. 2011, doi:10.1145/2063384.2063405) for a pack of rays.
 */
#include "compact/wave_random.h"

#include "base/intrinsics.h"

#define KEY0   0x9E3779B9u
#define KEY1   0xBB67AE85u
#define TIMES0 0xD2511F53u
#define TIMES1 0xCD9E8D57u
#define ROUNDS 10

static void draw(uint64_t seed, uint32_t c[4][W])
{
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    for (int round = 0; round < ROUNDS; round++, key0 += KEY0, key1 += KEY1) {
        EACH
        {
            uint64_t p0 = (uint64_t)c[0][i] * TIMES0, p1 = (uint64_t)c[2][i] * TIMES1;
            uint32_t c0 = (uint32_t)(p1 >> 32) ^ c[1][i] ^ key0;
            uint32_t c2 = (uint32_t)(p0 >> 32) ^ c[3][i] ^ key1;
            c[0][i] = c0;
            c[1][i] = (uint32_t)p1;
            c[2][i] = c2;
            c[3][i] = (uint32_t)p0;
        }
    }
}

#ifdef RMAP_INTRINSICS
#define AVX2 __attribute__((target("avx2")))

/* Every second ray: the low halves of 64 bits count, so that nothing need be taken apart. */
AVX2 static inline void rounds(uint64_t seed, __m256i c[4])
{
    const __m256i times0 = _mm256_set1_epi64x(TIMES0), times1 = _mm256_set1_epi64x(TIMES1);
    const __m256i more0 = _mm256_set1_epi32((int)KEY0), more1 = _mm256_set1_epi32((int)KEY1);
    __m256i key0 = _mm256_set1_epi32((int)(uint32_t)seed);
    __m256i key1 = _mm256_set1_epi32((int)(uint32_t)(seed >> 32));
    for (int round = 0; round < ROUNDS; round++) {
        __m256i p0 = _mm256_mul_epu32(c[0], times0), p1 = _mm256_mul_epu32(c[2], times1);
        __m256i high0 = _mm256_srli_epi64(p0, 32), high1 = _mm256_srli_epi64(p1, 32);
        c[0] = _mm256_xor_si256(_mm256_xor_si256(c[1], key0), high1);
        c[2] = _mm256_xor_si256(_mm256_xor_si256(c[3], key1), high0);
        c[1] = p1;
        c[3] = p0;
        key0 = _mm256_add_epi32(key0, more0);
        key1 = _mm256_add_epi32(key1, more1);
    }
}

AVX2 static void draw_8(uint64_t seed, uint32_t c[4][W])
{
    __m256i even[4], odd[4];
    for (int k = 0; k < 4; k++) {
        even[k] = _mm256_loadu_si256((const void *)c[k]);
        odd[k] = _mm256_srli_epi64(even[k], 32);
    }
    rounds(seed, even);
    rounds(seed, odd);
    for (int k = 0; k < 4; k++)
        _mm256_storeu_si256((void *)c[k],
                            _mm256_blend_epi32(even[k], _mm256_slli_epi64(odd[k], 32), 0xaa));
}

_Static_assert(W == 8, "a vector of 32 bits each");

void rmap_wave_draw(uint64_t seed, uint32_t counter[4][W])
{
    if (__builtin_cpu_supports("avx2"))
        draw_8(seed, counter);
    else
        draw(seed, counter);
}
#else
void rmap_wave_draw(uint64_t seed, uint32_t counter[4][W])
{
    draw(seed, counter);
}
#endif
