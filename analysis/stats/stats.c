/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats.h"

#include <math.h>
#include <string.h>

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

static void estimate_group(struct rmap_stats *stats, size_t g, const struct rmap_stats_sums *sums)
{
    const struct rmap_stats_setup *setup = stats->setup;
    const struct rmap_map *map = setup->quantities->map;
    const double *flux_per_weight = rmap_map_flux_per_weight(map);
    for (size_t i = 0; i < setup->quantities->n; i++) {
        double total[RMAP_MOMENTS] = {0.0}, covariance[RMAP_MOMENTS][RMAP_MOMENTS] = {{0.0}};
        for (size_t s = 0; s < setup->n_source; s++) {
            double q[RMAP_MOMENTS], product[RMAP_MOMENTS][RMAP_MOMENTS];
            size_t class = g * setup->n_source + s;
            rmap_stats_moments_value(&sums->moments[class * setup->quantities->n + i], q, product);
            for (size_t j = 0; j < RMAP_MOMENTS; j++) {
                total[j] += j == 0 ? rmap_map_flux(map, s, q[0]) : flux_per_weight[s] * q[j];
                for (size_t k = 0; k < RMAP_MOMENTS; k++)
                    covariance[j][k] += spread(map, s, q[j], q[k], product[j][k]);
            }
        }
        rmap_stats_estimate_moments(total, covariance, stats->plan->centre[i],
                                    stats->plan->scale[i], &stats->group[g].of[i].moment);
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
            size_t at = (g * setup->n_source + s) * n + c;
            const struct rmap_stats_cell *cell = &sums->cell[at];
            flux += rmap_map_flux_per_weight(map)[s] * cell->weight;
            variance += spread(map, s, cell->weight, cell->weight, cell->squared);
            rays += cell->rays;
        }
        stats->group[g].cell[c] = (struct rmap_stats_estimate){
            flux, isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0))};
        stats->group[g].cell_rays[c] = rays;
    }
}

static const char *group_name(const struct rmap_stats_setup *setup, size_t g)
{
    const struct rmap_scene *scene = setup->quantities->scene;
    if (setup->by == RMAP_STATS_TOGETHER)
        return NULL;
    return setup->by == RMAP_STATS_BY_SOURCE ? scene->source[g].name : scene->detector[g].name;
}

static enum rmap_status prepare_group(struct rmap_stats *stats, size_t g,
                                      const struct rmap_stats_range *range, struct rmap_error *err)
{
    const size_t n = stats->plan->n_cell + RMAP_STATS_BEYOND;
    struct rmap_stats_group *group = &stats->group[g];
    group->name = group_name(stats->setup, g);
    group->n_reading = range->n_reading;
    group->n_ray = range->n_cluster;
    group->cell = rmap_alloc(n, sizeof *group->cell);
    group->cell_rays = rmap_alloc(n, sizeof *group->cell_rays);
    bool short_of_memory = !group->cell || !group->cell_rays;
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
        rmap_free(stats->group[g].cell);
        rmap_free(stats->group[g].cell_rays);
        for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
            rmap_free(stats->group[g].of[i].quantile);
    }
    rmap_free(stats->group);
    rmap_free(stats);
}
