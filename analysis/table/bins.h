/* SPDX-License-Identifier: MIT
 *
 * Bins of a histogram. A bin holds its lower edge and not its upper one, but for the last, which
 * holds both.
 */
#ifndef RMAP_BINS_H
#define RMAP_BINS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct rmap_bins {
    size_t n;
    double *edge; /* [n + 1], ascending */
    bool uniform; /* as far as a guess may rely on it */
    bool logarithmic;
    double per; /* bins per unit, of uniform ones */
};
void rmap_bins_fini(struct rmap_bins *bins);

/* n equal bins, or (logarithmic; low > 0) bins of equal ratio. A range of no width gets some.
 * RMAP_SYSTEM. */
enum rmap_status rmap_bins_equal(double low, double high, size_t n, bool logarithmic,
                                 struct rmap_bins *bins, struct rmap_error *err) RMAP_MUST_USE;

/* About n bins over [low, high] with edges at round numbers. */
enum rmap_status rmap_bins_round(double low, double high, size_t n, struct rmap_bins *bins,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* One bin about each whole number in [low, high], or about each `step` of them. */
enum rmap_status rmap_bins_whole(double low, double high, size_t most, struct rmap_bins *bins,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Between edges [n + 1] given; copied. RMAP_USAGE unless they ascend. */
enum rmap_status rmap_bins_between(const double *edge, size_t n, struct rmap_bins *bins,
                                   struct rmap_error *err) RMAP_MUST_USE;

#define RMAP_BIN_BELOW ((size_t)-2)
#define RMAP_BIN_ABOVE ((size_t)-1)

/* Bin of a number. */
static inline size_t rmap_bin_of(const struct rmap_bins *bins, double v)
{
    const double *edge = bins->edge;
    size_t n = bins->n, k = 0;
    if (v < edge[0])
        return RMAP_BIN_BELOW;
    if (!(v < edge[n]))
        return v == edge[n] ? n - 1 : RMAP_BIN_ABOVE;
    if (bins->uniform) {
        k = (size_t)((v - edge[0]) * bins->per);
        k = k < n ? k : n - 1;
        while (v < edge[k])
            k--;
        while (v >= edge[k + 1])
            k++;
        return k;
    }
    for (size_t high = n; high - k > 1;) {
        size_t middle = (k + high) / 2;
        if (v < edge[middle])
            high = middle;
        else
            k = middle;
    }
    return k;
}

#endif
