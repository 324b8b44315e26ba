/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_hits.h"

#include "analysis/paths/path_hash.h"
#include "analysis/paths/path_key_internal.h"
#include "base/alloc.h"
#include "base/intrinsics.h"
#include "base/wide.h"

enum { LOW_TURN = 27, HIGH_TURN = 41 };
#define LOW_FACTOR  UINT64_C(0x9e3779b97f4a7c15)
#define HIGH_FACTOR UINT64_C(0xc2b2ae3d27d4eb4f)

void rmap_path_hits_fini(struct rmap_path_hits *hits)
{
    rmap_free(hits->word);
    *hits = (struct rmap_path_hits){0};
}

static inline uint64_t rotate(uint64_t x, int k)
{
    return x << k | x >> (64 - k);
}

struct hash {
    uint64_t low, high;
};

/* Two chains of steps that lose nothing, and nothing joins them before the end. */
static inline void mix(struct hash *hash, uint64_t word)
{
    hash->low = (rotate(hash->low, LOW_TURN) ^ word) * LOW_FACTOR;
    hash->high = (rotate(hash->high, HIGH_TURN) ^ word) * HIGH_FACTOR;
}

/* Registrations stand among the legs: each with its place there. n_hit is of all rows at first,
 * then of those of them that are registered. */
static inline void mix_ray(const struct rmap_path_hit *of_detector,
                           const struct rmap_registration_columns *hit,
                           const struct rmap_path_keyed *keyed, size_t k)
{
    struct hash hash = {keyed->low[k], keyed->high[k]};
    const size_t first = keyed->registration[k], behind = first + keyed->n_hit[k];
    const uint64_t n_leg = keyed->n_leg[k];
    uint64_t at = 0;
    uint32_t n_hit = 0;
    for (size_t i = first; i < behind; i++) {
        if (!hit->registered[i])
            continue;
        const struct rmap_path_hit of = of_detector[hit->detector[i]];
        uint64_t leg = (uint64_t)hit->segment[i] + of.follows;
        leg = leg < n_leg ? leg : n_leg;
        at = leg > at ? leg : at;
        mix(&hash, at << 32 | of.step);
        n_hit++;
    }
    keyed->low[k] = hash.low;
    keyed->high[k] = hash.high;
    keyed->n_hit[k] = n_hit;
}

/* Rays with registrations are listed first: which have some cannot be foreseen. */
static void mix_plain(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                      const struct rmap_path_keyed *keyed)
{
    enum { TOGETHER = 256 };
    uint32_t has[TOGETHER];
    for (size_t first = 0; first < keyed->n; first += TOGETHER) {
        const size_t left = keyed->n - first, end = first + (left < TOGETHER ? left : TOGETHER);
        size_t n = 0;
        for (size_t k = first; k < end; k++) {
            has[n] = (uint32_t)k;
            n += keyed->n_hit[k] > 0;
        }
        for (size_t i = 0; i < n; i++)
            mix_ray(keys->hit, &portion->registration, keyed, has[i]);
    }
}

#ifdef RMAP_INTRINSICS
#define AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))

/* So many are read from a place on. */
enum { WORDS_NEAR = 16 };

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}

/* A registration's place among the legs, or one far behind them, and its step. */
static inline uint64_t word_of(struct rmap_path_hit of, uint32_t leg)
{
    leg = leg < UINT32_MAX ? leg : UINT32_MAX - 1;
    return (uint64_t)(leg + of.follows) << 32 | of.step;
}

RMAP_WIDE static void spell_one(struct rmap_path_hit of, const uint32_t *restrict leg, size_t n,
                                uint64_t *restrict word)
{
    for (size_t i = 0; i < n; i++)
        word[i] = word_of(of, leg[i]);
}

/* All rows of the portion. */
static void spell(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                  uint64_t *word)
{
    const struct rmap_registration_columns *hit = &portion->registration;
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    if (keys->scene->n_detector == 1) {
        spell_one(keys->hit[0], hit->segment, n, word);
        return;
    }
    for (size_t i = 0; i < n; i++)
        word[i] = word_of(keys->hit[hit->detector[i]], hit->segment[i]);
}

/* Eight rays abreast, of which the bits of `there` are: a registration of each at a time. Mostly
 * they all stand in two registers: is_near; gathering them takes longer. */
AVX512 RMAP_COPIED void mix_eight(const uint64_t *word, const struct rmap_path_keyed *keyed,
                                  size_t k, __mmask8 there, bool is_near)
{
    const size_t begin = is_near ? keyed->registration[k] : 0;
    const __m512i near = _mm512_loadu_si512(word + begin);
    const __m512i far = _mm512_loadu_si512(word + begin + 8);
    const __m512i lower = _mm512_set1_epi64(UINT32_MAX);
    const __m512i low_factor = _mm512_set1_epi64((long long)LOW_FACTOR);
    const __m512i high_factor = _mm512_set1_epi64((long long)HIGH_FACTOR);
    const __m256i n_hit = _mm256_maskz_loadu_epi32(there, keyed->n_hit + k);
    const __m512i n_leg = _mm512_cvtepu32_epi64(_mm256_maskz_loadu_epi32(there, keyed->n_leg + k));
    __m512i row = _mm512_cvtepu32_epi64(_mm256_maskz_loadu_epi32(there, keyed->registration + k));
    row = _mm512_sub_epi64(row, _mm512_set1_epi64((long long)begin));
    __m512i low = _mm512_maskz_loadu_epi64(there, keyed->low + k);
    __m512i high = _mm512_maskz_loadu_epi64(there, keyed->high + k);
    __m512i at = _mm512_setzero_si512();
    __mmask8 has = _mm256_test_epi32_mask(n_hit, n_hit);
    for (int j = 1; j <= 2 || has; j++) { /* twice without a look: most eight have so many */
        const __m512i its = is_near ? _mm512_permutex2var_epi64(near, row, far)
                                    : _mm512_mask_i64gather_epi64(at, has, row, word, sizeof *word);
        const __m512i leg = _mm512_min_epu64(_mm512_srli_epi64(its, 32), n_leg);
        at = _mm512_mask_max_epu64(at, has, at, leg);
        const __m512i placed =
            _mm512_or_si512(_mm512_slli_epi64(at, 32), _mm512_and_si512(its, lower));
        low = _mm512_mask_mullo_epi64(
            low, has, _mm512_xor_si512(_mm512_rol_epi64(low, LOW_TURN), placed), low_factor);
        high = _mm512_mask_mullo_epi64(
            high, has, _mm512_xor_si512(_mm512_rol_epi64(high, HIGH_TURN), placed), high_factor);
        row = _mm512_add_epi64(row, _mm512_set1_epi64(1));
        has = _mm256_cmpgt_epu32_mask(n_hit, _mm256_set1_epi32(j));
    }
    _mm512_mask_storeu_epi64(keyed->low + k, there, low);
    _mm512_mask_storeu_epi64(keyed->high + k, there, high);
}

AVX512 static void mix_wide(const uint64_t *word, const struct rmap_path_keyed *keyed)
{
    for (size_t k = 0; k < keyed->n; k += 8) {
        const size_t last = k + 8 < keyed->n ? k + 7 : keyed->n - 1;
        const __mmask8 there = (__mmask8)(UINT8_MAX >> (7 - (last - k)));
        const uint32_t end = keyed->registration[last] + keyed->n_hit[last];
        if (end - keyed->registration[k] <= WORDS_NEAR)
            mix_eight(word, keyed, k, there, true);
        else
            mix_eight(word, keyed, k, there, false);
    }
}
#else
enum { WORDS_NEAR = 0 };

static bool is_wide(void)
{
    return false;
}

static void spell(const struct rmap_path_keys *keys, const struct rmap_portion *portion,
                  uint64_t *word)
{
    (void)keys;
    (void)portion;
    (void)word;
}

static void mix_wide(const uint64_t *word, const struct rmap_path_keyed *keyed)
{
    (void)word;
    (void)keyed;
}
#endif

RMAP_WIDE static bool are_registered(const uint8_t *registered, size_t n)
{
    uint8_t missing = 0;
    for (size_t i = 0; i < n; i++)
        missing |= registered[i] == 0;
    return !missing;
}

enum rmap_status rmap_path_hits_enter(struct rmap_path_hits *hits,
                                      const struct rmap_path_keys *keys,
                                      const struct rmap_portion *portion, struct rmap_error *err)
{
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    hits->any = n > 0;
    hits->is_spelled = n > 0 && is_wide() && are_registered(portion->registration.registered, n);
    if (!hits->is_spelled)
        return RMAP_OK;
    enum rmap_status st = RMAP_RESERVE(hits->word, hits->cap, n + WORDS_NEAR, err);
    if (st == RMAP_OK)
        spell(keys, portion, hits->word);
    return st;
}

void rmap_path_hits_mix(const struct rmap_path_hits *hits, const struct rmap_path_keys *keys,
                        const struct rmap_portion *portion, const struct rmap_path_keyed *keyed)
{
    if (hits->is_spelled)
        mix_wide(hits->word, keyed);
    else if (hits->any)
        mix_plain(keys, portion, keyed);
}
