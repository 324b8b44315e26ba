/* SPDX-License-Identifier: MIT
 *
 * Eight legs of a path at once: taken for granted that 0 always stands for the object before and
 * that light comes to surfaces in one of their media. For the files that unfold paths alone.
 */
#ifndef RMAP_COMPACT_PATH_WIDE_H
#define RMAP_COMPACT_PATH_WIDE_H

#include "base/intrinsics.h"
#include "compact/paths.h"

#ifdef RMAP_INTRINSICS
#define RMAP_PATHS_AVX2 __attribute__((target("avx2")))
#define AVX2            RMAP_PATHS_AVX2 static inline

/* Eight legs of a path. */
struct legs {
    __m256i object, sign; /* of those before; then of these: 1 + object */
    __m256i before, now;  /* last object and medium before these, in all lanes */
    __m256i happened, medium;
    __m256i missed, strange; /* -1: 0 did not stand for the object before, or something else did;
                                light came from nowhere */
};

AVX2 __m256i all(uint32_t x)
{
    return _mm256_set1_epi32((int)x);
}

AVX2 __m256i zeros(__m256i x)
{
    return _mm256_cmpeq_epi32(x, _mm256_setzero_si256());
}

AVX2 __m256i bit(__m256i x, int which)
{
    return _mm256_srai_epi32(_mm256_slli_epi32(x, 31 - which), 31);
}

AVX2 __m256i last(__m256i x)
{
    return _mm256_permutevar8x32_epi32(x, all(7));
}

/* Each lane becomes the one before it; the first becomes the last one of `before`. */
AVX2 __m256i behind(__m256i x, __m256i before)
{
    return _mm256_alignr_epi8(x, _mm256_permute2x128_si256(before, x, 0x21), 12);
}

/* Each lane becomes the exclusive or of itself and those before it. */
AVX2 __m256i running_xor(__m256i x)
{
    x = _mm256_xor_si256(x, behind(x, _mm256_setzero_si256()));
    __m256i low = _mm256_permute2x128_si256(x, x, 0x08);
    x = _mm256_xor_si256(x, _mm256_alignr_epi8(x, low, 8));
    return _mm256_xor_si256(x, _mm256_permute2x128_si256(x, x, 0x08));
}

/* For each set of lanes that are 0, which lane stands for each: the last before it that is not; 8:
 * none. */
#define FROM(m, k)                                                                                 \
    (!((m) >> (k)&1)                    ? (k)                                                      \
     : (k) > 0 && !((m) >> ((k)-1) & 1) ? (k)-1                                                    \
     : (k) > 1 && !((m) >> ((k)-2) & 1) ? (k)-2                                                    \
     : (k) > 2 && !((m) >> ((k)-3) & 1) ? (k)-3                                                    \
     : (k) > 3 && !((m) >> ((k)-4) & 1) ? (k)-4                                                    \
     : (k) > 4 && !((m) >> ((k)-5) & 1) ? (k)-5                                                    \
     : (k) > 5 && !((m) >> ((k)-6) & 1) ? (k)-6                                                    \
     : (k) > 6 && !((m) >> ((k)-7) & 1) ? (k)-7                                                    \
                                        : 8)
#define SET(m)                                                                                     \
    {                                                                                              \
        FROM(m, 0), FROM(m, 1), FROM(m, 2), FROM(m, 3), FROM(m, 4), FROM(m, 5), FROM(m, 6),        \
            FROM(m, 7)                                                                             \
    }
#define SETS_4(m)  SET(m), SET((m) + 1), SET((m) + 2), SET((m) + 3)
#define SETS_16(m) SETS_4(m), SETS_4((m) + 4), SETS_4((m) + 8), SETS_4((m) + 12)
#define SETS_64(m) SETS_16(m), SETS_16((m) + 16), SETS_16((m) + 32), SETS_16((m) + 48)
static const uint8_t stands[256][8] = {SETS_64(0), SETS_64(64), SETS_64(128), SETS_64(192)};

/* Lanes of 0 become the last one before that is not. */
AVX2 __m256i filled(__m256i word, __m256i zero, __m256i carry)
{
    int set = _mm256_movemask_ps(_mm256_castsi256_ps(zero));
    __m256i from = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *)stands[set]));
    __m256i full = _mm256_permutevar8x32_epi32(word, from); /* 8: of lane 0, which is 0 */
    return _mm256_or_si256(full, _mm256_and_si256(carry, zeros(full)));
}

/* The legs whose stored words these are. */
AVX2 void step_8(const uint32_t *sign, __m256i word, __m256i event, struct legs *l)
{
    const __m256i low = all((1u << RMAP_SIGN_MEDIUM_BITS) - 1);
    const __m256i through = all(RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_TRANSMIT_DIFFUSE);
    __m256i zero = zeros(word), object = filled(word, zero, l->before);
    __m256i s = _mm256_i32gather_epi32((const int *)sign, object, 4);
    l->happened =
        _mm256_xor_si256(event, _mm256_and_si256(s, all((1u << RMAP_SIGN_EVENT_BITS) - 1)));
    __m256i front = _mm256_and_si256(_mm256_srli_epi32(s, RMAP_SIGN_FRONT), low);
    __m256i differs = _mm256_and_si256(_mm256_srli_epi32(s, RMAP_SIGN_CHANGE), low);
    __m256i change = _mm256_andnot_si256(zeros(_mm256_and_si256(l->happened, through)), differs);
    __m256i after = _mm256_xor_si256(l->now, running_xor(change));
    l->medium = _mm256_xor_si256(after, change);
    __m256i off = _mm256_xor_si256(l->medium, front);
    __m256i fits = _mm256_or_si256(zeros(off), _mm256_cmpeq_epi32(off, differs));
    l->strange = _mm256_andnot_si256(_mm256_or_si256(fits, bit(s, RMAP_SIGN_ANY)), all(UINT32_MAX));
    __m256i met = behind(object, l->object), sign_met = behind(s, l->sign);
    __m256i both = _mm256_srli_epi32(sign_met, RMAP_SIGN_FRONT);
    __m256i inside = _mm256_xor_si256(both, _mm256_srli_epi32(both, RMAP_SIGN_MEDIUM_BITS));
    inside = zeros(_mm256_and_si256(_mm256_xor_si256(inside, l->medium), low));
    inside = _mm256_and_si256(inside, bit(sign_met, RMAP_SIGN_CLOSED));
    __m256i swaps = _mm256_and_si256(_mm256_or_si256(zero, _mm256_cmpeq_epi32(word, met)), inside);
    l->missed = _mm256_xor_si256(swaps, zero);
    l->object = object;
    l->sign = s;
    l->before = last(object);
    l->now = last(after);
}

/* Into rows [k, k + 8). */
AVX2 void put_8(const struct legs *l, const struct rmap_path_columns *out, size_t k)
{
    _mm256_storeu_si256((void *)(out->object + k), _mm256_sub_epi32(l->object, all(1)));
    _mm256_storeu_si256((void *)(out->event + k), l->happened);
    if (!out->medium)
        return;
    __m256i halves = _mm256_permute4x64_epi64(_mm256_packs_epi32(l->medium, l->medium), 0xd8);
    _mm_storeu_si128((void *)(out->medium + k), _mm256_castsi256_si128(halves));
}

AVX2 unsigned lanes(__m256i x)
{
    return (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(x));
}

/* False: it was not as taken for granted. n > 0. */
AVX2 bool unfold_wide(const uint32_t *sign, uint32_t medium, const struct rmap_folded_path *path,
                      const struct rmap_path_columns *out)
{
    const __m256i zero = _mm256_setzero_si256();
    struct legs l = {.object = zero, .sign = zero, .before = zero, .now = all(medium)};
    unsigned wrong = 0;
    size_t k = 0, n = path->n;
    for (;; k += 8) {
        step_8(sign, _mm256_loadu_si256((const void *)(path->object + k)),
               _mm256_loadu_si256((const void *)(path->event + k)), &l);
        put_8(&l, out, k);
        if (n - k <= 8)
            break;
        wrong |= lanes(_mm256_or_si256(l.missed, l.strange));
    }
    unsigned end = 1u << (n - k - 1), missed = lanes(l.missed);
    if (missed & end) /* the last leg may meet nothing */
        out->object[n - 1] = -1;
    return ((wrong | ((missed | lanes(l.strange)) & (end - 1)))) == 0;
}

/* A guided path; the event of the last leg is that of one in between. False: leg by leg. */
AVX2 bool rmap_path_unfold_8(const struct rmap_compact_model *model,
                             const struct rmap_folded_path *path,
                             const struct rmap_path_columns *out)
{
    size_t whole = (path->n + 7) / 8 * 8;
    uint32_t medium = (uint32_t)rmap_first_medium(model, path->source);
    return path->n > 0 && whole <= path->n_stored && whole <= out->n_row &&
           medium < model->n_medium && unfold_wide(model->sign, medium, path, out);
}

/* Eight legs of a path that is unfolded. */
AVX2 void copy_8(const struct rmap_path_columns *from, size_t k, const struct rmap_path_columns *to)
{
    _mm256_storeu_si256((void *)(to->object + k),
                        _mm256_loadu_si256((const void *)(from->object + k)));
    _mm256_storeu_si256((void *)(to->event + k),
                        _mm256_loadu_si256((const void *)(from->event + k)));
    if (to->medium)
        _mm_storeu_si128((void *)(to->medium + k),
                         _mm_loadu_si128((const void *)(from->medium + k)));
}
#endif

#endif
