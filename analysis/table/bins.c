/* SPDX-License-Identifier: MIT
 *
 * Bins of a histogram.
 */
#include "analysis/table/bins.h"

#include <math.h>

#include "analysis/table/figure_axes.h"
#include "base/alloc.h"

void rmap_bins_fini(struct rmap_bins *bins)
{
    rmap_free(bins->edge);
    *bins = (struct rmap_bins){0};
}

static enum rmap_status allocate(size_t n, struct rmap_bins *bins, struct rmap_error *err)
{
    *bins = (struct rmap_bins){.n = n, .edge = rmap_alloc(n + 1, sizeof *bins->edge)};
    if (bins->edge)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", n);
}

static void finish_uniform(struct rmap_bins *bins)
{
    bins->uniform = true;
    bins->per = (double)bins->n / (bins->edge[bins->n] - bins->edge[0]);
    if (!isfinite(bins->per))
        bins->uniform = false;
}

/* A range that has a width. */
static void part(double *low, double *high)
{
    if (*low < *high)
        return;
    double half = *low == 0.0 ? 0.5 : 0.5 * fabs(*low);
    *low -= half;
    *high += half;
}

enum rmap_status rmap_bins_equal(double low, double high, size_t n, bool logarithmic,
                                 struct rmap_bins *bins, struct rmap_error *err)
{
    part(&low, &high);
    enum rmap_status st = allocate(n, bins, err);
    if (st != RMAP_OK)
        return st;
    const double from = logarithmic ? log(low) : low, to = logarithmic ? log(high) : high;
    for (size_t k = 0; k <= n; k++) {
        double at = from + (to - from) * (double)k / (double)n;
        bins->edge[k] = logarithmic ? exp(at) : at;
    }
    bins->edge[0] = low;
    bins->edge[n] = high;
    bins->logarithmic = logarithmic;
    if (!logarithmic)
        finish_uniform(bins);
    return RMAP_OK;
}

enum rmap_status rmap_bins_round(double low, double high, size_t n, struct rmap_bins *bins,
                                 struct rmap_error *err)
{
    part(&low, &high);
    /* A step that is 1, 2 or 5 times a power of ten, and no finer than asked for. */
    double exact = (high - low) / (double)n, step = rmap_round_below(exact);
    if (step < exact * (1 - 1e-12))
        step = rmap_round_below(2.5000001 * step);
    double first = floor(low / step), last = ceil(high / step);
    if (!(last - first >= 1.0 && last - first <= 4.0 * (double)n))
        return rmap_bins_equal(low, high, n, false, bins, err);
    enum rmap_status st = allocate((size_t)(last - first), bins, err);
    if (st != RMAP_OK)
        return st;
    /* Steps below 1 are the reciprocal of a whole number: edges come out as people write them. */
    const double over = step < 1.0 ? round(1.0 / step) : 1.0;
    for (size_t k = 0; k <= bins->n; k++)
        bins->edge[k] = step < 1.0 ? (first + (double)k) / over : (first + (double)k) * step;
    finish_uniform(bins);
    return RMAP_OK;
}

enum rmap_status rmap_bins_whole(double low, double high, size_t most, struct rmap_bins *bins,
                                 struct rmap_error *err)
{
    double step = ceil((high - low + 1.0) / (double)most);
    size_t n = (size_t)ceil((high - low + 1.0) / step);
    enum rmap_status st = allocate(n, bins, err);
    if (st != RMAP_OK)
        return st;
    for (size_t k = 0; k <= n; k++)
        bins->edge[k] = low - 0.5 + step * (double)k;
    finish_uniform(bins);
    return RMAP_OK;
}

enum rmap_status rmap_bins_between(const double *edge, size_t n, struct rmap_bins *bins,
                                   struct rmap_error *err)
{
    for (size_t k = 0; k < n; k++)
        if (!(edge[k] < edge[k + 1]))
            return rmap_error_set(err, RMAP_USAGE, "--bins: edges must ascend: %g, %g", edge[k],
                                  edge[k + 1]);
    enum rmap_status st = allocate(n, bins, err);
    for (size_t k = 0; st == RMAP_OK && k <= n; k++)
        bins->edge[k] = edge[k];
    return st;
}
