/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_windows.h"

#include "base/intrinsics.h"

void rmap_stats_windows_over(struct rmap_stats_windows *windows, const uint16_t *bin, size_t n)
{
    for (uint32_t gap = 2;; gap *= 2) { /* bins so near to each other share a window */
        windows->n = 0;
        size_t k = 0;
        while (k < n && windows->n < RMAP_STATS_WINDOWS) {
            const uint16_t first = bin[k];
            for (k++; k < n && (uint32_t)bin[k] - bin[k - 1] <= gap;)
                k++;
            windows->first[windows->n] = first;
            windows->more[windows->n++] = (uint16_t)(bin[k - 1] - first);
        }
        if (k == n)
            return;
    }
}

#ifdef RMAP_INTRINSICS
enum { LANES = 16 };

/* n: a multiple of LANES. At least one window. */
__attribute__((target("avx2"))) static size_t pick_wide(const struct rmap_stats_windows *windows,
                                                        const uint16_t *place, size_t n,
                                                        uint32_t *picked)
{
    __m256i first[RMAP_STATS_WINDOWS], more[RMAP_STATS_WINDOWS];
    size_t n_picked = 0;
    for (size_t w = 0; w < RMAP_STATS_WINDOWS; w++) { /* missing ones as the first one */
        first[w] = _mm256_set1_epi16((short)windows->first[w < windows->n ? w : 0]);
        more[w] = _mm256_set1_epi16((short)windows->more[w < windows->n ? w : 0]);
    }
    for (size_t k = 0; k < n; k += LANES) {
        const __m256i its = _mm256_loadu_si256((const void *)(place + k));
        __m256i beyond = _mm256_set1_epi16(-1); /* the nearest window's end; 0: within it */
        for (size_t w = 0; w < RMAP_STATS_WINDOWS; w++)
            beyond = _mm256_min_epu16(beyond,
                                      _mm256_subs_epu16(_mm256_sub_epi16(its, first[w]), more[w]));
        const __m256i in = _mm256_cmpeq_epi16(beyond, _mm256_setzero_si256());
        uint32_t bits = (uint32_t)_mm256_movemask_epi8(in) & 0x55555555;
        /* Often there is none, seldom more than one: which of these is not asked. */
        picked[n_picked] = (uint32_t)(k + (size_t)__builtin_ctz(bits | 0x80000000) / 2);
        n_picked += bits != 0;
        for (bits &= bits - 1; bits; bits &= bits - 1)
            picked[n_picked++] = (uint32_t)(k + (size_t)__builtin_ctz(bits) / 2);
    }
    return n_picked;
}

static size_t wide_part(size_t n)
{
    return __builtin_cpu_supports("avx2") ? n / LANES * LANES : 0;
}
#else
#define pick_wide(windows, place, n, picked) ((size_t)0)
#define wide_part(n)                         ((size_t)0)
#endif

size_t rmap_stats_windows_pick(const struct rmap_stats_windows *windows, const uint16_t *place,
                               size_t n, uint32_t *picked)
{
    const size_t n_wide = windows->n > 0 ? wide_part(n) : 0;
    size_t n_picked = n_wide > 0 ? pick_wide(windows, place, n_wide, picked) : 0;
    for (size_t k = n_wide; k < n; k++)
        picked[n_picked++] = (uint32_t)k;
    return n_picked;
}
