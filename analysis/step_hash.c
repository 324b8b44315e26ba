/* SPDX-License-Identifier: MIT */
#include "analysis/step_hash.h"

#include <stdbool.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/intrinsics.h"

enum { BLOCK = RMAP_STEP_HASH_BLOCK, SETS = RMAP_STEP_HASH_SETS, WORDS = RMAP_STEP_HASH_BLOCK / 4 };

/* SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195). */
static uint64_t next_random(uint64_t *state)
{
    uint64_t x = *state += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

void rmap_step_hash_keys_init(struct rmap_step_hash_keys *keys)
{
    uint64_t state = UINT64_C(0x7261796d6170); /* "raymap" */
    for (int b = 0; b < RMAP_STEP_HASH_BLOCKS; b++)
        for (int s = 0; s < SETS; s++)
            for (int w = 0; w < WORDS; w++)
                keys->key[b][s][w] = (uint32_t)(next_random(&state) >> 32);
}

static inline uint64_t rotate(uint64_t x, int k)
{
    return x << k | x >> (64 - k);
}

/* Two words of two sums, one to one for either sum; upper bits, too, come down. */
static inline uint64_t join(uint64_t a, uint64_t b)
{
    const uint64_t x = (a ^ rotate(b, 32)) * UINT64_C(0x9e3779b97f4a7c15);
    return (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
}

/* Lengths tell rows apart of which one ends in zeros. */
static inline struct rmap_step_hash finish(const uint64_t sum[SETS], size_t nbytes)
{
    const uint64_t low = join(sum[0] + nbytes, sum[1]), high = join(sum[2] + nbytes, sum[3]);
    return (struct rmap_step_hash){low ^ low >> 29, high ^ high >> 29};
}

static struct rmap_step_hash hash_long(const uint8_t *step, size_t nbytes)
{
    const XXH128_hash_t hash = XXH3_128bits(step, nbytes);
    return (struct rmap_step_hash){hash.low64, hash.high64};
}

static inline bool is_long(size_t nbytes)
{
    return nbytes > (size_t)BLOCK * RMAP_STEP_HASH_BLOCKS;
}

static void add_block(const uint32_t key[SETS][WORDS], const uint8_t *step, size_t nbytes,
                      uint64_t sum[SETS])
{
    uint32_t word[WORDS] = {0};
    memcpy(word, step, nbytes < BLOCK ? nbytes : BLOCK);
    for (int s = 0; s < SETS; s++)
        for (int w = 0; w < WORDS; w += 2)
            sum[s] +=
                (uint64_t)(uint32_t)(word[w] + key[s][w]) * (uint32_t)(word[w + 1] + key[s][w + 1]);
}

static struct rmap_step_hash hash_plain(const struct rmap_step_hash_keys *keys, const uint8_t *step,
                                        size_t nbytes)
{
    uint64_t sum[SETS] = {0};
    if (is_long(nbytes))
        return hash_long(step, nbytes);
    for (size_t at = 0, b = 0; b == 0 || at < nbytes; at += BLOCK, b++)
        add_block(keys->key[b], step + at, nbytes - at, sum);
    return finish(sum, nbytes);
}

void rmap_step_hash_rows_plain(const struct rmap_step_hash_keys *keys, const uint8_t *steps,
                               const struct rmap_step_row *row, size_t n,
                               struct rmap_step_hash *hash)
{
    for (size_t i = 0; i < n; i++)
        hash[i] = hash_plain(keys, steps + row[i].first, row[i].nbytes);
}

#ifdef RMAP_INTRINSICS
#define AVX2 __attribute__((target("avx2"))) static inline

/* So many bytes that stay, and none behind. */
static const uint8_t window[2 * BLOCK] = {255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255,
                                          255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255,
                                          255, 255, 255, 255, 255, 255, 255, 255, 255, 255};

AVX2 __m256i load(const void *from)
{
    return _mm256_loadu_si256(from);
}

AVX2 __m256i product(__m256i words, const uint32_t key[WORDS])
{
    const __m256i keyed = _mm256_add_epi32(words, load(key));
    return _mm256_mul_epu32(keyed, _mm256_srli_epi64(keyed, 32));
}

AVX2 void add_wide(const uint32_t key[SETS][WORDS], __m256i words, __m256i sum[SETS])
{
    for (int s = 0; s < SETS; s++)
        sum[s] = _mm256_add_epi64(sum[s], product(words, key[s]));
}

/* Each set's four sums in one. */
AVX2 __m256i gather(const __m256i sum[SETS])
{
    const __m256i a = _mm256_add_epi64(_mm256_unpacklo_epi64(sum[0], sum[1]),
                                       _mm256_unpackhi_epi64(sum[0], sum[1]));
    const __m256i b = _mm256_add_epi64(_mm256_unpacklo_epi64(sum[2], sum[3]),
                                       _mm256_unpackhi_epi64(sum[2], sum[3]));
    return _mm256_add_epi64(_mm256_permute2x128_si256(a, b, 0x20),
                            _mm256_permute2x128_si256(a, b, 0x31));
}

AVX2 struct rmap_step_hash hash_wide(const struct rmap_step_hash_keys *keys, const uint8_t *step,
                                     size_t nbytes)
{
    uint64_t all[SETS];
    __m256i sum[SETS];
    size_t b = 0, left = nbytes;
    for (int s = 0; s < SETS; s++)
        sum[s] = _mm256_setzero_si256();
    for (; left > BLOCK; left -= BLOCK, b++)
        add_wide(keys->key[b], load(step + b * BLOCK), sum);
    add_wide(keys->key[b], _mm256_and_si256(load(step + b * BLOCK), load(window + BLOCK - left)),
             sum);
    _mm256_storeu_si256((__m256i *)all, gather(sum));
    return finish(all, nbytes);
}

__attribute__((target("avx2"))) static void rows_wide(const struct rmap_step_hash_keys *keys,
                                                      const uint8_t *steps,
                                                      const struct rmap_step_row *row, size_t n,
                                                      struct rmap_step_hash *hash)
{
    for (size_t i = 0; i < n; i++)
        hash[i] = is_long(row[i].nbytes) ? hash_long(steps + row[i].first, row[i].nbytes)
                                         : hash_wide(keys, steps + row[i].first, row[i].nbytes);
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
#define rows_wide rmap_step_hash_rows_plain

static bool is_wide(void)
{
    return false;
}
#endif

void rmap_step_hash_rows(const struct rmap_step_hash_keys *keys, const uint8_t *steps,
                         const struct rmap_step_row *row, size_t n, struct rmap_step_hash *hash)
{
    if (is_wide())
        rows_wide(keys, steps, row, n, hash);
    else
        rmap_step_hash_rows_plain(keys, steps, row, n, hash);
}
