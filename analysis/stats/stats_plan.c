/* SPDX-License-Identifier: MIT
 *
 * How readings are summed, from what is known of their ranges.
 */
#include <math.h>

#include "analysis/stats/stats.h"
#include "base/alloc.h"

/* With the readings in memory a fine histogram need not be finer than the cache likes. */
enum {
    FINE_BINS = 65536,
    CACHED_BINS = 8192,
    LEAST_FINE_BINS = 1024,
    DEFAULT_BINS = 50,
    LEAST_BINS = 10
};
static const double FINE_NBYTES = 64.0 * 1024.0 * 1024.0;

static double bins_asked(const struct rmap_stats_axis *axis)
{
    if (axis->edge)
        return (double)axis->n_edge - 1.0;
    return axis->n_bin > 0 ? (double)axis->n_bin : 4.0 * DEFAULT_BINS;
}

static size_t n_fine(const struct rmap_stats_setup *setup, bool in_memory)
{
    const double most = in_memory ? CACHED_BINS : FINE_BINS;
    double n = FINE_NBYTES / sizeof(double) / (double)(setup->n_class * setup->quantities->n + 1);
    return (size_t)fmin(fmax(n, LEAST_FINE_BINS), most);
}

enum rmap_status rmap_stats_check_bins(const struct rmap_stats_setup *setup,
                                       const struct rmap_stats_axis *axis, struct rmap_error *err)
{
    double n_cell = 1.0;
    for (size_t i = 0; i < setup->quantities->n; i++)
        n_cell *= bins_asked(&axis[i]);
    double nbytes = rmap_stats_sums_nbytes(setup, n_cell, (double)n_fine(setup, false));
    if (nbytes <= RMAP_STATS_NBYTES_MAX)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "%.0f bins in %zu groups and sources would take %.1f GiB per thread; "
                          "statistics use 1 GiB at most: ask for fewer --bins",
                          n_cell, setup->n_class, nbytes / RMAP_STATS_NBYTES_MAX);
}

/* Over all groups. */
static struct rmap_stats_range whole_range(const struct rmap_stats_setup *setup,
                                           const struct rmap_stats_range *range, size_t quantity)
{
    struct rmap_stats_range whole = range[quantity];
    for (size_t g = 1; g < setup->n_group; g++) {
        const struct rmap_stats_range *own = &range[g * setup->quantities->n + quantity];
        whole.low = fmin(whole.low, own->low);
        whole.high = fmax(whole.high, own->high);
        whole.least_positive = fmin(whole.least_positive, own->least_positive);
        whole.n_reading += own->n_reading;
        rmap_exact_sum_merge(&whole.sum, &own->sum);
        rmap_exact_sum_merge(&whole.squared, &own->squared);
    }
    return whole;
}

/* The bands of the map's channels, which stand for what is nearer to them than to others. */
static enum rmap_status band_bins(const struct rmap_channels *channels, struct rmap_bins *bins,
                                  struct rmap_error *err)
{
    double edge[RMAP_CHANNEL_MAX + 1];
    const double *at = channels->wavelength_nm;
    const size_t n = (size_t)channels->n;
    for (size_t k = 1; k < n; k++)
        edge[k] = 0.5 * (at[k - 1] + at[k]);
    edge[0] = at[0] - (edge[1] - at[0]);
    edge[n] = at[n - 1] + (at[n - 1] - edge[n - 1]);
    return rmap_bins_between(edge, n, bins, err);
}

static bool has_bands(const struct rmap_quantities *quantities, size_t index)
{
    const struct rmap_quantity *quantity = &quantities->of[index];
    const struct rmap_channels *channels = &quantities->scene->channels;
    return quantity->kind == RMAP_QUANTITY_RAY_NUMBER &&
           quantity->ray_number == RMAP_RAY_NUMBER_WAVELENGTH &&
           channels->mode == RMAP_COLOUR_SPECTRAL && channels->n > 1 &&
           rmap_map_n_space(quantities->map) == 1;
}

/* Few far values should not squeeze all others into one bin: whole numbers that have one each are
 * not squeezed. */
static const double DEVIATIONS = 6.0;

/* All of a group where that is one value, or none can be told. */
static void cut_tail(const struct rmap_stats_range *range, bool whole, double *low, double *high)
{
    const double n = (double)range->n_reading;
    const double mean = rmap_exact_sum_value(&range->sum) / n;
    const double square = rmap_exact_sum_value(&range->squared) / n;
    const double reach = DEVIATIONS * sqrt(fmax(square - mean * mean, 0.0));
    *low = range->low;
    *high = range->high;
    if (!(reach > 0.0) || !isfinite(reach))
        return;
    *low = fmax(*low, whole ? floor(mean - reach) : mean - reach);
    *high = fmin(*high, whole ? ceil(mean + reach) : mean + reach);
}

/* What no group has but in its tails. group: the ranges of groups, `stride` apart. */
static void cut_tails(const struct rmap_stats_range *group, size_t n_group, size_t stride,
                      bool whole, double *low, double *high)
{
    double least = (double)INFINITY, most = -(double)INFINITY;
    for (size_t g = 0; g < n_group; g++) {
        double its_low, its_high;
        if (group[g * stride].n_reading == 0)
            continue;
        cut_tail(&group[g * stride], whole, &its_low, &its_high);
        least = fmin(least, its_low);
        most = fmax(most, its_high);
    }
    *low = fmax(*low, least);
    *high = fmin(*high, most);
}

/* group: the ranges of its values in each group; range: in all. */
static enum rmap_status choose_bins(const struct rmap_stats_setup *setup, size_t index,
                                    const struct rmap_stats_range *group,
                                    const struct rmap_stats_range *range,
                                    const struct rmap_stats_axis *axis, struct rmap_bins *bins,
                                    struct rmap_error *err)
{
    double low = range->low, high = range->high;
    if (axis->edge)
        return rmap_bins_between(axis->edge, axis->n_edge - 1, bins, err);
    if (range->n_reading == 0) {
        low = axis->logarithmic ? 1.0 : 0.0;
        high = axis->logarithmic ? 10.0 : 1.0;
    }
    if (axis->logarithmic && range->n_reading > 0)
        low = isfinite(range->least_positive) ? range->least_positive : 1.0;
    if (axis->has_range) {
        low = axis->range[0];
        high = axis->range[1];
    }
    if (axis->logarithmic && !(low > 0.0))
        return rmap_error_set(err, RMAP_USAGE, "--log wants a range above 0, not from %g", low);
    const double fitting = ceil(2.0 * cbrt((double)range->n_reading));
    const size_t n = (size_t)fmin(fmax(fitting, LEAST_BINS), DEFAULT_BINS);
    if (axis->n_bin > 0 || axis->logarithmic || axis->has_range)
        return rmap_bins_equal(low, high < low ? low : high, axis->n_bin > 0 ? axis->n_bin : n,
                               axis->logarithmic, bins, err);
    if (has_bands(setup->quantities, index))
        return band_bins(&setup->quantities->scene->channels, bins, err);
    const bool whole = setup->quantities->of[index].is_whole;
    if (range->n_reading > 0 && !(whole && high - low < DEFAULT_BINS))
        cut_tails(group, setup->n_group, setup->quantities->n, whole, &low, &high);
    if (whole)
        return rmap_bins_whole(low, high, 2 * DEFAULT_BINS, bins, err);
    return rmap_bins_round(low, high, n, bins, err);
}

static void choose_fine(struct rmap_stats_plan *plan, size_t i,
                        const struct rmap_stats_range *range)
{
    const double width = range->high - range->low;
    plan->fine_low[i] = range->n_reading > 0 ? range->low : 0.0;
    plan->fine_per[i] = width > 0.0 ? (double)plan->n_fine / width : 0.0;
    if (!isfinite(plan->fine_per[i]))
        plan->fine_per[i] = 0.0;
    if (plan->setup->quantities->of[i].is_whole && width < (double)plan->n_fine - 1.0) {
        plan->fine_low[i] -= 0.5; /* a bin for each whole number */
        plan->fine_per[i] = 1.0;
    }
}

enum rmap_status rmap_stats_plan_init(struct rmap_stats_plan *plan,
                                      const struct rmap_stats_setup *setup,
                                      const struct rmap_stats_known *known,
                                      const struct rmap_stats_range *range,
                                      const struct rmap_stats_axis *axis, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *plan = (struct rmap_stats_plan){
        .setup = setup, .n_cell = 1, .n_fine = n_fine(setup, !known->dropped)};
    for (size_t i = 0; i < setup->quantities->n; i++) {
        struct rmap_stats_range whole = whole_range(setup, range, i);
        plan->scale[i] = 1.0;
        if (whole.n_reading > 0) {
            plan->centre[i] = rmap_exact_sum_value(&whole.sum) / (double)whole.n_reading;
            double reach = fmax(whole.high - plan->centre[i], plan->centre[i] - whole.low);
            plan->scale[i] = reach > 0.0 && isfinite(reach) ? reach : 1.0;
        }
        plan->per_scale[i] = 1.0 / plan->scale[i];
        if (!isfinite(plan->per_scale[i]))
            plan->scale[i] = plan->per_scale[i] = 1.0;
        choose_fine(plan, i, &whole);
        RMAP_TRY(choose_bins(setup, i, &range[i], &whole, &axis[i], &plan->bins[i], err));
        plan->n_cell *= plan->bins[i].n;
    }
out:
    return st;
}

void rmap_stats_plan_fini(struct rmap_stats_plan *plan)
{
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        rmap_bins_fini(&plan->bins[i]);
}
