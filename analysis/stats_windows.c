/* SPDX-License-Identifier: MIT */
#include "analysis/stats_windows.h"

#include <string.h>

#include "base/wide.h"

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

enum { LANES = 16 };
typedef uint16_t vector __attribute__((vector_size(LANES * sizeof(uint16_t))));

/* n: a multiple of LANES. At least one window. */
RMAP_WIDE static size_t pick_wide(const struct rmap_stats_windows *windows, const uint16_t *place,
                                  size_t n, uint32_t *picked)
{
    vector first[RMAP_STATS_WINDOWS], more[RMAP_STATS_WINDOWS];
    size_t n_picked = 0;
    for (size_t w = 0; w < RMAP_STATS_WINDOWS; w++) { /* missing ones as the first one */
        first[w] = (vector){0} + windows->first[w < windows->n ? w : 0];
        more[w] = (vector){0} + windows->more[w < windows->n ? w : 0];
    }
    for (size_t k = 0; k < n; k += LANES) {
        vector its, in = {0};
        uint64_t four[LANES / 4];
        memcpy(&its, place + k, sizeof its);
        for (size_t w = 0; w < RMAP_STATS_WINDOWS; w++)
            in |= (vector)(its - first[w] <= more[w]);
        memcpy(four, &in, sizeof four);
        if (!(four[0] | four[1] | four[2] | four[3]))
            continue;
        for (size_t f = 0; f < LANES / 4; f++)
            for (size_t i = 0; i < 4; i++) { /* no branch */
                picked[n_picked] = (uint32_t)(k + 4 * f + i);
                n_picked += four[f] >> 16 * i & 1;
            }
    }
    return n_picked;
}

size_t rmap_stats_windows_pick(const struct rmap_stats_windows *windows, const uint16_t *place,
                               size_t n, uint32_t *picked)
{
    const size_t n_wide = windows->n > 0 ? n / LANES * LANES : 0;
    size_t n_picked = n_wide > 0 ? pick_wide(windows, place, n_wide, picked) : 0;
    for (size_t k = n_wide; k < n; k++)
        picked[n_picked++] = (uint32_t)k;
    return n_picked;
}
