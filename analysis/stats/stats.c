/* SPDX-License-Identifier: MIT
 *
 * Statistics of one or two numbers of rays or registrations: flux, mean, standard deviation,
 * skewness, kurtosis, quantiles and a histogram, weighted by flux, each with its standard error.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/stats/stats.h"
#include "analysis/stats/stats_quantile.h"
#include "base/alloc.h"

/* a_j = d statistic / d (T_j / T_0): its error from the covariances of T. */
static struct rmap_stats_estimate by_delta(double value, const double a[RMAP_MOMENTS],
                                           const double moment[RMAP_MOMENTS], double flux,
                                           double covariance[RMAP_MOMENTS][RMAP_MOMENTS],
                                           double unit)
{
    double slope[RMAP_MOMENTS] = {0.0}, variance = 0.0;
    for (size_t j = 1; j < RMAP_MOMENTS; j++) {
        slope[j] = a[j] / flux;
        slope[0] -= a[j] * moment[j] / flux;
    }
    for (size_t j = 0; j < RMAP_MOMENTS; j++)
        for (size_t k = 0; k < RMAP_MOMENTS; k++)
            variance += slope[j] * slope[k] * covariance[j][k];
    return (struct rmap_stats_estimate){value, isnan(variance) ? (double)NAN
                                                               : sqrt(fmax(variance, 0.0)) * unit};
}

void rmap_stats_estimate_moments(const double total[RMAP_MOMENTS],
                                 double covariance[RMAP_MOMENTS][RMAP_MOMENTS], double centre,
                                 double scale, struct rmap_stats_moment_estimates *estimates)
{
    const double flux = total[0];
    const struct rmap_stats_estimate unknown = {(double)NAN, (double)NAN};
    *estimates =
        (struct rmap_stats_moment_estimates){{0.0, 0.0}, unknown, unknown, unknown, unknown};
    estimates->flux = (struct rmap_stats_estimate){
        flux, isnan(covariance[0][0]) ? (double)NAN : sqrt(fmax(covariance[0][0], 0.0))};
    if (!(flux > 0.0))
        return;
    double m[RMAP_MOMENTS];
    for (size_t j = 0; j < RMAP_MOMENTS; j++)
        m[j] = total[j] / flux;
    const double m1 = m[1], square = m1 * m1;
    const double second = fmax(m[2] - square, 0.0), deviation = sqrt(second);
    const double third = m[3] - 3.0 * m1 * m[2] + 2.0 * m1 * square;
    const double fourth = m[4] - 4.0 * m1 * m[3] + 6.0 * square * m[2] - 3.0 * square * square;
    const double of_mean[RMAP_MOMENTS] = {0.0, 1.0, 0.0, 0.0, 0.0};
    const double of_third[RMAP_MOMENTS] = {0.0, 6.0 * square - 3.0 * m[2], -3.0 * m1, 1.0, 0.0};
    const double of_fourth[RMAP_MOMENTS] = {0.0, 12.0 * m1 * m[2] - 4.0 * m[3] - 12.0 * m1 * square,
                                            6.0 * square, -4.0 * m1, 1.0};
    double of_deviation[RMAP_MOMENTS] = {0.0}, of_skewness[RMAP_MOMENTS], of_kurtosis[RMAP_MOMENTS];
    estimates->mean = by_delta(centre + scale * m1, of_mean, m, flux, covariance, scale);
    estimates->deviation.value = scale * deviation;
    if (!(deviation > 1e-12)) /* all readings are one number, as far as sums can tell */
        return;
    const double cube = second * deviation;
    of_deviation[1] = -m1 / deviation;
    of_deviation[2] = 0.5 / deviation;
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        double of_second = 2.0 * deviation * of_deviation[j];
        of_skewness[j] = of_third[j] / cube - 1.5 * third / (cube * second) * of_second;
        of_kurtosis[j] =
            of_fourth[j] / (second * second) - 2.0 * fourth / (cube * cube) * of_second;
    }
    estimates->deviation = by_delta(scale * deviation, of_deviation, m, flux, covariance, scale);
    estimates->skewness = by_delta(third / cube, of_skewness, m, flux, covariance, 1.0);
    estimates->kurtosis =
        by_delta(fourth / (second * second), of_kurtosis, m, flux, covariance, 1.0);
}

/* Variance that the sums of q and of q^2 of one source stand for, or covariance. */
static double spread(const struct rmap_map *map, size_t source, double q, double r, double qr)
{
    const double n = rmap_map_emitted(map)[source], f = rmap_map_flux_per_weight(map)[source];
    if (q == 0.0 && r == 0.0 && qr == 0.0)
        return 0.0;
    return n < 2.0 ? (double)NAN : f * f * n / (n - 1.0) * (qr - q * r / n);
}

/* Readings that are all the same are known exactly, of more than one ray; sums about another
 * centre leave rounding. */
static void tell_one_number(struct rmap_stats_summary *of, uint64_t n_ray)
{
    const struct rmap_stats_estimate unknown = {(double)NAN, (double)NAN};
    if (!(of->least >= of->greatest))
        return;
    of->moment.mean = (struct rmap_stats_estimate){of->least, n_ray > 1 ? 0.0 : (double)NAN};
    of->moment.deviation = (struct rmap_stats_estimate){0.0, (double)NAN};
    of->moment.skewness = of->moment.kurtosis = unknown;
}

static void estimate_group(struct rmap_stats *stats, size_t g, const struct rmap_stats_sums *sums)
{
    const struct rmap_stats_setup *setup = stats->setup;
    const struct rmap_map *map = setup->quantities->map;
    const double *flux_per_weight = rmap_map_flux_per_weight(map);
    for (size_t i = 0; i < setup->quantities->n; i++) {
        double total[RMAP_MOMENTS] = {0.0}, covariance[RMAP_MOMENTS][RMAP_MOMENTS] = {{0.0}};
        for (size_t s = 0; s < setup->n_source; s++) {
            double q[RMAP_MOMENTS], product[RMAP_MOMENTS][RMAP_MOMENTS];
            const size_t class = g * setup->n_source + s;
            const size_t source = rmap_stats_setup_source(setup, g, s);
            rmap_stats_moments_value(&sums->moments[class * setup->quantities->n + i], q, product);
            for (size_t j = 0; j < RMAP_MOMENTS; j++) {
                total[j] +=
                    j == 0 ? rmap_map_flux(map, source, q[0]) : flux_per_weight[source] * q[j];
                for (size_t k = 0; k < RMAP_MOMENTS; k++)
                    covariance[j][k] += spread(map, source, q[j], q[k], product[j][k]);
            }
        }
        rmap_stats_estimate_moments(total, covariance, stats->plan->centre[i],
                                    stats->plan->scale[i], &stats->group[g].of[i].moment);
        tell_one_number(&stats->group[g].of[i], stats->group[g].n_ray);
    }
    stats->group[g].flux = stats->group[g].of[0].moment.flux;
}

static void estimate_cells(struct rmap_stats *stats, size_t g, const struct rmap_stats_sums *sums)
{
    const struct rmap_stats_setup *setup = stats->setup;
    const struct rmap_map *map = setup->quantities->map;
    const size_t n = stats->plan->n_cell + RMAP_STATS_BEYOND;
    for (size_t c = 0; c < n; c++) {
        double flux = 0.0, variance = 0.0, rays = 0.0;
        for (size_t s = 0; s < setup->n_source; s++) {
            const size_t at = (g * setup->n_source + s) * n + c;
            const size_t source = rmap_stats_setup_source(setup, g, s);
            const struct rmap_stats_cell *cell = &sums->cell[at];
            flux += rmap_map_flux_per_weight(map)[source] * cell->weight;
            variance += spread(map, source, cell->weight, cell->weight, cell->squared);
            rays += cell->rays;
        }
        stats->group[g].cell[c] = (struct rmap_stats_estimate){
            flux, isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0))};
        stats->group[g].cell_rays[c] = rays;
    }
}

static enum rmap_status prepare_group(struct rmap_stats *stats, size_t g,
                                      const struct rmap_stats_range *range, struct rmap_error *err)
{
    const size_t n = stats->plan->n_cell + RMAP_STATS_BEYOND;
    struct rmap_stats_group *group = &stats->group[g];
    const char *criterion = rmap_stats_setup_criterion(stats->setup, g);
    group->name = rmap_stats_setup_name(stats->setup, g);
    if (criterion) {
        const size_t nbytes = strlen(group->name) + strlen(criterion) + sizeof " of ";
        group->named = rmap_alloc(nbytes, 1);
        if (group->named)
            (void)snprintf(group->named, nbytes, "%s of %s", group->name, criterion);
        group->name = group->named;
    }
    group->n_reading = range->n_reading;
    group->n_ray = range->n_cluster;
    group->cell = rmap_alloc(n, sizeof *group->cell);
    group->cell_rays = rmap_alloc(n, sizeof *group->cell_rays);
    bool short_of_memory = !group->cell || !group->cell_rays || (criterion && !group->named);
    for (size_t i = 0; i < stats->setup->quantities->n; i++) {
        struct rmap_stats_summary *of = &group->of[i];
        of->least = group->n_reading > 0 ? range[i].low : (double)NAN;
        of->greatest = group->n_reading > 0 ? range[i].high : (double)NAN;
        of->quantile = rmap_alloc(stats->n_quantile + 1, sizeof *of->quantile);
        short_of_memory = short_of_memory || !of->quantile;
    }
    if (!short_of_memory)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for statistics of %zu bins",
                          stats->plan->n_cell);
}

enum rmap_status rmap_stats_create(const struct rmap_stats_plan *plan,
                                   const struct rmap_stats_gathered *gathered,
                                   const struct rmap_stats_sums *sums, const double *p,
                                   size_t n_quantile, struct rmap_stats **stats_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_group = plan->setup->n_group;
    struct rmap_stats *stats = rmap_alloc(1, sizeof *stats);
    if (stats)
        stats->group = rmap_alloc(n_group + 1, sizeof *stats->group);
    if (!stats || !stats->group) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu groups", n_group);
        goto out;
    }
    stats->setup = plan->setup;
    stats->plan = plan;
    stats->known = gathered->known;
    stats->n_group = n_group;
    stats->p = p;
    stats->n_quantile = n_quantile;
    for (size_t g = 0; g < n_group; g++) {
        RMAP_TRY(prepare_group(stats, g, gathered->range + g * plan->setup->quantities->n, err));
        estimate_group(stats, g, sums);
        estimate_cells(stats, g, sums);
    }
    RMAP_TRY(rmap_stats_find_quantiles(stats, gathered, sums, err));
    *stats_ret = stats;
    stats = NULL;
out:
    rmap_stats_destroy(stats);
    return st;
}

void rmap_stats_destroy(struct rmap_stats *stats)
{
    if (!stats)
        return;
    for (size_t g = 0; stats->group && g < stats->n_group; g++) {
        rmap_free(stats->group[g].named);
        rmap_free(stats->group[g].cell);
        rmap_free(stats->group[g].cell_rays);
        for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
            rmap_free(stats->group[g].of[i].quantile);
    }
    rmap_free(stats->group);
    rmap_free(stats);
}

/* How readings are summed, from what is known of their ranges. */

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
    const double fine = (double)n_fine(setup, false);
    const double nbytes = rmap_stats_sums_nbytes(setup, n_cell, fine);
    if (nbytes <= RMAP_STATS_NBYTES_MAX)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "%.0f bins in %zu groups and sources would take %.1f GiB per thread; "
                          "statistics use 1 GiB at most: ask for fewer %s",
                          n_cell, setup->n_class, nbytes / RMAP_STATS_NBYTES_MAX,
                          rmap_stats_sums_nbytes(setup, 1.0, fine) > RMAP_STATS_NBYTES_MAX
                              ? "groups (--by, --where)"
                              : "--bins");
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
