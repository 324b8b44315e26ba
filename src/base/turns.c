/* SPDX-License-Identifier: MIT */
#include "base/turns.h"

#include "base/intrinsics.h"

/* Numbers of a step are read at once: so many, or NEAR where they stand in these. */
enum { ABREAST = RMAP_TURNS_ABREAST, NEAR = 2 * ABREAST, FAR = 4 * ABREAST };

static size_t common(size_t a, size_t b)
{
    return b == 0 ? a : common(b, a % b);
}

/* Place of number i of those picked. */
static size_t place_of(const struct rmap_turns *turns, size_t i)
{
    return i / turns->n * turns->period + turns->place[i % turns->n];
}

/* Steps that end beyond what is read at once are none. */
static void lay_steps(struct rmap_turns *turns)
{
    size_t furthest = 0;
    turns->n_step = 0;
    if (turns->n == 0)
        return;
    const size_t n_step = turns->n / common(turns->n, ABREAST);
    for (size_t s = 0; s < n_step; s++) {
        struct rmap_turns_step *step = &turns->step[s];
        const size_t first = place_of(turns, s * ABREAST);
        const size_t span = place_of(turns, s * ABREAST + ABREAST - 1) - first + 1;
        if (span > FAR)
            return;
        step->first = (uint16_t)first;
        for (size_t k = 0; k < ABREAST; k++)
            step->after[k] = (uint8_t)(place_of(turns, s * ABREAST + k) - first);
        furthest = span > furthest ? span : furthest;
    }
    turns->n_step = n_step;
    turns->stride = n_step * ABREAST / turns->n * turns->period;
    turns->are_near = furthest <= NEAR;
    turns->reach = turns->step[n_step - 1].first + (size_t)(turns->are_near ? NEAR : FAR);
}

void rmap_turns_init(struct rmap_turns *turns, const int32_t *cycle, size_t period, size_t phase,
                     int32_t which)
{
    turns->period = period;
    turns->n = 0;
    for (size_t k = 0; k < period; k++)
        if (cycle[(k + phase) % period] == which)
            turns->place[turns->n++] = (uint8_t)k;
    lay_steps(turns);
}

#ifdef RMAP_INTRINSICS
#define TARGET __attribute__((target("avx512f"), always_inline)) static inline

TARGET __m512d pick_near(const double *from, __m512i after)
{
    return _mm512_permutex2var_pd(_mm512_loadu_pd(from), after, _mm512_loadu_pd(from + ABREAST));
}

TARGET __m512d pick_step(const struct rmap_turns_step *step, const double *value, bool are_near)
{
    const double *from = value + step->first;
    const __m512i after = _mm512_cvtepu8_epi64(_mm_loadl_epi64((const void *)step->after));
    const __m512d near = pick_near(from, after);
    if (are_near)
        return near;
    const __mmask8 is_far = _mm512_test_epi64_mask(after, _mm512_set1_epi64(NEAR));
    return _mm512_mask_blend_pd(is_far, near, pick_near(from + NEAR, after));
}

/* All steps, as often as there is all that they read; returns how often. */
TARGET size_t pick_all(const struct rmap_turns *turns, const double *value, size_t n, double *to,
                       bool are_near)
{
    size_t times = 0;
    for (size_t left = n; left >= turns->reach && left >= turns->stride; times++) {
        for (size_t s = 0; s < turns->n_step; s++, to += ABREAST)
            _mm512_storeu_pd(to, pick_step(&turns->step[s], value, are_near));
        value += turns->stride;
        left -= turns->stride;
    }
    return times;
}

__attribute__((target("avx512f"))) static size_t
pick_wide(const struct rmap_turns *turns, const double *value, size_t n, double *to)
{
    return turns->are_near ? pick_all(turns, value, n, to, true)
                           : pick_all(turns, value, n, to, false);
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx512f");
}
#else
#define pick_wide(turns, value, n, to) ((size_t)0)
#define is_wide()                      false
#endif

size_t rmap_turns_pick(const struct rmap_turns *turns, const double *value, size_t n, double *to)
{
    const size_t times = turns->n_step > 0 && is_wide() ? pick_wide(turns, value, n, to) : 0;
    size_t at = times * turns->n_step * ABREAST;
    for (size_t base = times * turns->stride; base < n; base += turns->period)
        for (size_t k = 0; k < turns->n && base + turns->place[k] < n; k++)
            to[at++] = value[base + turns->place[k]];
    return at;
}
