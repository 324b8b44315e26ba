/* SPDX-License-Identifier: MIT */
#include "base/rng.h"

#include <Random123/philox.h>

#include "base/wide.h"

#if defined(__SSE2__)
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define PAIRS 1 /* where the machine has AVX2 */
#else
#include <emmintrin.h>
#define PAIRS 0
#endif

/* A counter whose numbers 0 and 2 stand in `even`, 1 and 3 in `odd`, each in the low half of 64
 * bits: one multiplication makes both products of a round. The same bits as Random123's. */
struct halves {
    __m128i even, odd;
};

#define PICKED(third, first) _MM_SHUFFLE(3, third, 1, first)

static inline struct halves halves_of(const struct rmap_rng_counter *counter)
{
    uint32_t low = (uint32_t)counter->ray, high = (uint32_t)(counter->ray >> 32);
    return (struct halves){_mm_set_epi32(0, (int)counter->step, 0, (int)low),
                           _mm_set_epi32(0, (int)counter->slot, 0, (int)high)};
}

static inline void stir(struct halves *halves, __m128i key)
{
    const __m128i times = _mm_set_epi32(0, (int)PHILOX_M4x32_1, 0, (int)PHILOX_M4x32_0);
    __m128i product = _mm_mul_epu32(halves->even, times);
    halves->even =
        _mm_xor_si128(_mm_shuffle_epi32(product, PICKED(1, 3)), _mm_xor_si128(halves->odd, key));
    halves->odd = _mm_shuffle_epi32(product, PICKED(0, 2));
}

/* Bits below the point of 2^52: a double of 2^52 + bits. */
static inline __m128d uniform_of(__m128i bits)
{
    const __m128i low = _mm_set1_epi64x(UINT32_MAX);
    __m128d whole = _mm_or_pd(_mm_castsi128_pd(_mm_and_si128(bits, low)), _mm_set1_pd(0x1p52));
    return _mm_mul_pd(_mm_sub_pd(whole, _mm_set1_pd(0x1p52 - 0.5)), _mm_set1_pd(0x1p-32));
}

/* Abreast: a round waits for the one before it longer than a machine needs to issue several. */
RMAP_COPIED void draw(uint64_t seed, const struct rmap_rng_counter *counter, int n,
                      double (*uniform)[4])
{
    const __m128i more = _mm_set_epi32(0, (int)PHILOX_W32_1, 0, (int)PHILOX_W32_0);
    __m128i key = _mm_set_epi32(0, (int)(uint32_t)(seed >> 32), 0, (int)(uint32_t)seed);
    struct halves halves[2];
    for (int i = 0; i < n; i++)
        halves[i] = halves_of(&counter[i]);
    RMAP_UNROLL
    for (int round = 0; round < philox4x32_rounds; round++) {
        for (int i = 0; i < n; i++)
            stir(&halves[i], key);
        key = _mm_add_epi32(key, more);
    }
    for (int i = 0; i < n; i++) {
        __m128d even = uniform_of(halves[i].even), odd = uniform_of(halves[i].odd);
        _mm_storeu_pd(&uniform[i][0], _mm_unpacklo_pd(even, odd));
        _mm_storeu_pd(&uniform[i][2], _mm_unpackhi_pd(even, odd));
    }
}

#if PAIRS
#define RMAP_AVX2  __attribute__((target("avx2")))
#define BOTH(half) _mm256_broadcastsi128_si256(half)

/* Two counters side by side: what stir() and uniform_of() do, twice at a time. */
struct pairs {
    __m256i even, odd;
};

RMAP_AVX2 static inline void stir_pair(struct pairs *pair, __m256i key)
{
    const __m256i times = BOTH(_mm_set_epi32(0, (int)PHILOX_M4x32_1, 0, (int)PHILOX_M4x32_0));
    __m256i product = _mm256_mul_epu32(pair->even, times);
    pair->even = _mm256_xor_si256(_mm256_shuffle_epi32(product, PICKED(1, 3)),
                                  _mm256_xor_si256(pair->odd, key));
    pair->odd = _mm256_shuffle_epi32(product, PICKED(0, 2));
}

RMAP_AVX2 static inline __m256d uniform_of_pair(__m256i bits)
{
    const __m256i low = _mm256_set1_epi64x(UINT32_MAX);
    const __m256d one = _mm256_set1_pd(0x1p52), less = _mm256_set1_pd(0x1p52 - 0.5);
    __m256d whole = _mm256_or_pd(_mm256_castsi256_pd(_mm256_and_si256(bits, low)), one);
    return _mm256_mul_pd(_mm256_sub_pd(whole, less), _mm256_set1_pd(0x1p-32));
}

RMAP_AVX2 static void draw_pair(uint64_t seed, const struct rmap_rng_counter counter[2],
                                double uniform[2][4])
{
    const __m256i more = BOTH(_mm_set_epi32(0, (int)PHILOX_W32_1, 0, (int)PHILOX_W32_0));
    __m256i key = BOTH(_mm_set_epi32(0, (int)(uint32_t)(seed >> 32), 0, (int)(uint32_t)seed));
    struct halves first = halves_of(&counter[0]), second = halves_of(&counter[1]);
    struct pairs pair = {_mm256_set_m128i(second.even, first.even),
                         _mm256_set_m128i(second.odd, first.odd)};
    RMAP_UNROLL
    for (int round = 0; round < philox4x32_rounds; round++) {
        stir_pair(&pair, key);
        key = _mm256_add_epi32(key, more);
    }
    __m256d even = uniform_of_pair(pair.even), odd = uniform_of_pair(pair.odd);
    __m256d front = _mm256_unpacklo_pd(even, odd), back = _mm256_unpackhi_pd(even, odd);
    _mm256_storeu_pd(uniform[0], _mm256_permute2f128_pd(front, back, 0x20));
    _mm256_storeu_pd(uniform[1], _mm256_permute2f128_pd(front, back, 0x31));
}
#endif
#else
#define PAIRS 0
static void draw(uint64_t seed, const struct rmap_rng_counter *counter, int n, double (*uniform)[4])
{
    for (int k = 0; k < n; k++) {
        uint32_t low = (uint32_t)counter[k].ray, high = (uint32_t)(counter[k].ray >> 32);
        philox4x32_key_t key = {{(uint32_t)seed, (uint32_t)(seed >> 32)}};
        philox4x32_ctr_t bits = {{low, high, counter[k].step, (uint32_t)counter[k].slot}};
        bits = philox4x32(bits, key);
        for (int i = 0; i < 4; i++)
            uniform[k][i] = ((double)bits.v[i] + 0.5) * 0x1p-32;
    }
}
#endif

void rmap_rng(uint64_t seed, uint64_t ray, uint32_t step, enum rmap_rng_slot slot,
              double uniform[4])
{
    const struct rmap_rng_counter counter = {ray, step, slot};
    double of[1][4];
    draw(seed, &counter, 1, of);
    for (int i = 0; i < 4; i++)
        uniform[i] = of[0][i];
}

void rmap_rng_two(uint64_t seed, const struct rmap_rng_counter counter[2], double uniform[2][4])
{
#if PAIRS
    if (__builtin_cpu_supports("avx2")) {
        draw_pair(seed, counter, uniform);
        return;
    }
#endif
    draw(seed, counter, 2, uniform);
}
