/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_levels.h"

#include "base/alloc.h"
#include "base/wide.h"

/* Bins in one step. */
enum { STEP = 64 };

RMAP_WIDE static uint64_t count_of(const uint32_t *single, size_t n)
{
    uint64_t count = 0;
    for (size_t k = 0; k < n; k++)
        count += single[k];
    return count;
}

/* Weight in bins [first, end) of a class. */
static double weight_of(const struct rmap_stats_levels *levels, size_t class, size_t first,
                        size_t end)
{
    const struct rmap_stats_plan *plan = levels->sums->plan;
    const size_t row =
        (class * plan->setup->quantities->n + levels->quantity) * plan->n_fine + first;
    const double *fine = levels->sums->fine ? levels->sums->fine + row : NULL;
    double weight = (double)count_of(levels->sums->fine_single + row, end - first);
    for (size_t k = 0; fine && k < end - first; k++)
        weight += fine[k];
    return weight;
}

enum rmap_status rmap_stats_levels_init(struct rmap_stats_levels *levels,
                                        const struct rmap_stats_sums *sums, size_t quantity,
                                        struct rmap_error *err)
{
    const size_t n_fine = sums->plan->n_fine, n_class = sums->plan->setup->n_class;
    const size_t n_step = (n_fine + STEP - 1) / STEP;
    *levels = (struct rmap_stats_levels){.sums = sums, .quantity = quantity, .n_step = n_step};
    levels->before = rmap_alloc(n_class * (n_step + 1), sizeof *levels->before);
    if (!levels->before)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t class = 0; class < n_class; class ++) {
        double *before = levels->before + class * (n_step + 1);
        for (size_t k = 0; k < n_step; k++) {
            const size_t first = k * STEP, end = first + STEP;
            before[k + 1] =
                before[k] + weight_of(levels, class, first, end < n_fine ? end : n_fine);
        }
    }
    return RMAP_OK;
}

void rmap_stats_levels_fini(struct rmap_stats_levels *levels)
{
    rmap_free(levels->before);
}

double rmap_stats_levels_weight(const struct rmap_stats_levels *levels, size_t class, size_t bin)
{
    const size_t k = bin < levels->sums->plan->n_fine ? bin / STEP : levels->n_step;
    const double before = levels->before[class * (levels->n_step + 1) + k];
    return bin > k * STEP ? before + weight_of(levels, class, k * STEP, bin) : before;
}

double rmap_stats_levels_flux(const struct rmap_stats_levels *levels, size_t group, size_t bin)
{
    const struct rmap_stats_setup *setup = levels->sums->plan->setup;
    const double *per_weight = rmap_map_flux_per_weight(setup->quantities->map);
    double flux = 0.0;
    for (size_t s = 0; s < setup->n_source; s++)
        flux += per_weight[s] * rmap_stats_levels_weight(levels, group * setup->n_source + s, bin);
    return flux;
}

static bool is_reached(const struct rmap_stats_levels *levels, size_t group, size_t bin,
                       double target)
{
    const double flux = rmap_stats_levels_flux(levels, group, bin);
    return flux >= target && flux > 0.0;
}

/* First of [low, high) that are `each` bins at whose end the target is reached, or high. */
static size_t first_of(const struct rmap_stats_levels *levels, size_t group, double target,
                       size_t each, size_t low, size_t high)
{
    const size_t n_fine = levels->sums->plan->n_fine;
    while (low < high) {
        const size_t middle = (low + high) / 2, end = (middle + 1) * each;
        if (is_reached(levels, group, end < n_fine ? end : n_fine, target))
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

size_t rmap_stats_levels_bin(const struct rmap_stats_levels *levels, size_t group, double target)
{
    const size_t n_fine = levels->sums->plan->n_fine;
    const size_t first = first_of(levels, group, target, STEP, 0, levels->n_step) * STEP;
    const size_t end = first + STEP < n_fine ? first + STEP : n_fine;
    const size_t bin = first < n_fine ? first_of(levels, group, target, 1, first, end) : n_fine;
    return bin < n_fine ? bin : n_fine - 1;
}
