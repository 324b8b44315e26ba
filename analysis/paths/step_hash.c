/* SPDX-License-Identifier: MIT */
#include "analysis/paths/step_hash.h"

#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/intrinsics.h"
#include "base/wide.h"

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
    const uint64_t y = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return y ^ y >> 29;
}

/* Rows that are summed together. */
enum { TOGETHER = 256 };

struct sums {
    uint64_t set[SETS][TOGETHER];
};

/* Lengths tell rows apart of which one ends in zeros. Either half has a sum of its own, and both
 * the third. */
RMAP_WIDE_PRODUCTS static void join_sums(const struct sums *sums, const uint32_t *count, int shift,
                                         size_t n, uint64_t *restrict low, uint64_t *restrict high)
{
    for (size_t i = 0; i < n; i++) {
        const uint64_t nbytes = (uint64_t)count[i] << shift;
        low[i] = join(sums->set[0][i] + nbytes, sums->set[1][i]);
        high[i] = join(sums->set[2][i] + nbytes, sums->set[1][i]);
    }
}

static const uint8_t *row_at(const struct rmap_step_rows *rows, size_t i, size_t *nbytes_ret)
{
    const int shift = rows->is_narrow ? 1 : 2;
    *nbytes_ret = (size_t)rows->count[i] << shift;
    return (const uint8_t *)rows->steps + ((size_t)rows->first[i] << shift);
}

static inline bool is_long(size_t nbytes)
{
    return nbytes > (size_t)BLOCK * RMAP_STEP_HASH_BLOCKS;
}

static void hash_long(const uint8_t *step, size_t nbytes, uint64_t *low, uint64_t *high)
{
    const XXH128_hash_t hash = XXH3_128bits(step, nbytes);
    *low = hash.low64;
    *high = hash.high64;
}

static void add_block(const uint32_t key[SETS][WORDS], const uint8_t *step, size_t nbytes,
                      struct sums *sums, size_t row)
{
    uint32_t word[WORDS] = {0};
    memcpy(word, step, nbytes < BLOCK ? nbytes : BLOCK);
    for (int s = 0; s < SETS; s++)
        for (int w = 0; w < WORDS; w += 2)
            sums->set[s][row] +=
                (uint64_t)(uint32_t)(word[w] + key[s][w]) * (uint32_t)(word[w + 1] + key[s][w + 1]);
}

/* Rows [first, first + n), at most TOGETHER. True: some of them are long, and not done. */
typedef bool hash_some(const struct rmap_step_hash_keys *keys, const struct rmap_step_rows *rows,
                       size_t first, size_t n, uint64_t *low, uint64_t *high);

static bool some_plain(const struct rmap_step_hash_keys *keys, const struct rmap_step_rows *rows,
                       size_t first, size_t n, uint64_t *low, uint64_t *high)
{
    struct sums sums;
    bool any_long = false;
    for (size_t i = 0; i < n; i++) {
        size_t nbytes;
        const uint8_t *step = row_at(rows, first + i, &nbytes);
        for (int s = 0; s < SETS; s++)
            sums.set[s][i] = 0;
        for (size_t at = 0, b = 0; !is_long(nbytes) && (b == 0 || at < nbytes); at += BLOCK, b++)
            add_block(keys->key[b], step + at, nbytes - at, &sums, i);
        any_long |= is_long(nbytes);
    }
    join_sums(&sums, rows->count + first, rows->is_narrow ? 1 : 2, n, low, high);
    return any_long;
}

static void hash_rows(hash_some *some, const struct rmap_step_hash_keys *keys,
                      const struct rmap_step_rows *rows, uint64_t *low, uint64_t *high)
{
    bool any_long = false;
    for (size_t first = 0; first < rows->n; first += TOGETHER) {
        const size_t left = rows->n - first, n = left < TOGETHER ? left : TOGETHER;
        any_long |= some(keys, rows, first, n, low + first, high + first);
    }
    for (size_t i = 0; any_long && i < rows->n; i++) {
        size_t nbytes;
        const uint8_t *step = row_at(rows, i, &nbytes);
        if (is_long(nbytes))
            hash_long(step, nbytes, &low[i], &high[i]);
    }
}

void rmap_step_hash_rows_plain(const struct rmap_step_hash_keys *keys,
                               const struct rmap_step_rows *rows, uint64_t *low, uint64_t *high)
{
    hash_rows(some_plain, keys, rows, low, high);
}

#ifdef RMAP_INTRINSICS
#define AVX2 __attribute__((target("avx2")))

/* So many bytes that stay, and none behind. */
static const uint8_t window[2 * BLOCK] = {255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255,
                                          255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255,
                                          255, 255, 255, 255, 255, 255, 255, 255, 255, 255};

AVX2 static inline __m256i load(const void *from)
{
    return _mm256_loadu_si256(from);
}

/* The first BLOCK bytes of a row: behind it zeros. */
AVX2 static inline __m256i load_row(const uint8_t *step, size_t nbytes)
{
    const size_t stay = nbytes < BLOCK ? nbytes : BLOCK;
    return _mm256_and_si256(load(step), load(window + BLOCK - stay));
}

AVX2 static inline __m256i product(__m256i words, const uint32_t key[WORDS])
{
    const __m256i keyed = _mm256_add_epi32(words, load(key));
    return _mm256_mul_epu32(keyed, _mm256_srli_epi64(keyed, 32));
}

/* Each one's four numbers in one. */
AVX2 static inline __m256i gather(__m256i a, __m256i b, __m256i c, __m256i d)
{
    const __m256i ab = _mm256_add_epi64(_mm256_unpacklo_epi64(a, b), _mm256_unpackhi_epi64(a, b));
    const __m256i cd = _mm256_add_epi64(_mm256_unpacklo_epi64(c, d), _mm256_unpackhi_epi64(c, d));
    return _mm256_add_epi64(_mm256_permute2x128_si256(ab, cd, 0x20),
                            _mm256_permute2x128_si256(ab, cd, 0x31));
}

/* First blocks of four rows from row i on. */
AVX2 RMAP_COPIED void sum_four(const uint32_t key[SETS][WORDS], const uint8_t *steps,
                               const uint32_t *first, const uint32_t *count, int shift,
                               struct sums *sums, size_t i)
{
    __m256i words[4];
    for (size_t r = 0; r < 4; r++)
        words[r] = load_row(steps + ((size_t)first[i + r] << shift), (size_t)count[i + r] << shift);
    for (int s = 0; s < SETS; s++)
        _mm256_storeu_si256((__m256i *)&sums->set[s][i],
                            gather(product(words[0], key[s]), product(words[1], key[s]),
                                   product(words[2], key[s]), product(words[3], key[s])));
}

/* Blocks of a row from block b on. */
AVX2 static void add_blocks(const struct rmap_step_hash_keys *keys, const uint8_t *step,
                            size_t nbytes, size_t b, struct sums *sums, size_t i)
{
    enum { GATHERED = 4 }; /* of which the sets are the first */
    uint64_t all[GATHERED];
    __m256i sum[GATHERED];
    for (int s = 0; s < GATHERED; s++)
        sum[s] = _mm256_setzero_si256();
    for (; b == 0 || b * BLOCK < nbytes; b++) {
        const __m256i words = load_row(step + b * BLOCK, nbytes - b * BLOCK);
        for (int s = 0; s < SETS; s++)
            sum[s] = _mm256_add_epi64(sum[s], product(words, keys->key[b][s]));
    }
    _mm256_storeu_si256((__m256i *)all, gather(sum[0], sum[1], sum[2], sum[3]));
    for (int s = 0; s < SETS; s++)
        sums->set[s][i] += all[s];
}

/* Most rows are of one block: these are summed four at a time, without a look at their lengths; of
 * longer ones what is behind it is added. True: some are long. */
AVX2 RMAP_COPIED bool sum_rows(const struct rmap_step_hash_keys *keys,
                               const struct rmap_step_rows *rows, size_t begin, size_t n, int shift,
                               struct sums *sums)
{
    const uint32_t *first = rows->first + begin, *count = rows->count + begin;
    const uint8_t *steps = rows->steps;
    uint32_t more[TOGETHER];
    bool any_long = false;
    size_t i = 0, n_more = 0;
    for (; i + 4 <= n; i += 4)
        sum_four(keys->key[0], steps, first, count, shift, sums, i);
    for (; i < n; i++) {
        for (int s = 0; s < SETS; s++)
            sums->set[s][i] = 0;
        add_blocks(keys, steps + ((size_t)first[i] << shift),
                   count[i] < (uint32_t)BLOCK >> shift ? (size_t)count[i] << shift : BLOCK, 0, sums,
                   i);
    }
    for (i = 0; i < n; i++) {
        more[n_more] = (uint32_t)i;
        n_more += count[i] > (uint32_t)BLOCK >> shift;
    }
    for (size_t k = 0; k < n_more; k++) {
        const size_t nbytes = (size_t)count[more[k]] << shift;
        any_long |= is_long(nbytes);
        if (!is_long(nbytes))
            add_blocks(keys, steps + ((size_t)first[more[k]] << shift), nbytes, 1, sums, more[k]);
    }
    return any_long;
}

AVX2 static bool sum_wide(const struct rmap_step_hash_keys *keys, const struct rmap_step_rows *rows,
                          size_t first, size_t n, struct sums *sums)
{
    return rows->is_narrow ? sum_rows(keys, rows, first, n, 1, sums)
                           : sum_rows(keys, rows, first, n, 2, sums);
}

AVX2 static bool some_avx2(const struct rmap_step_hash_keys *keys,
                           const struct rmap_step_rows *rows, size_t first, size_t n, uint64_t *low,
                           uint64_t *high)
{
    struct sums sums;
    const bool any_long = sum_wide(keys, rows, first, n, &sums);
    join_sums(&sums, rows->count + first, rows->is_narrow ? 1 : 2, n, low, high);
    return any_long;
}

static hash_some *best(void)
{
    return __builtin_cpu_supports("avx2") ? some_avx2 : some_plain;
}
#else
static hash_some *best(void)
{
    return some_plain;
}
#endif

void rmap_step_hash_rows(const struct rmap_step_hash_keys *keys, const struct rmap_step_rows *rows,
                         uint64_t *low, uint64_t *high)
{
    hash_rows(best(), keys, rows, low, high);
}
