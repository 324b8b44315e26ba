/* SPDX-License-Identifier: MIT
 *
 * Quantiles: the least value with at least a share p of the flux at or below it, and their errors.
 */
#include <math.h>

#include "analysis/stats/stats_search.h"
#include "base/alloc.h"

/* Sums over the clusters of a class: a is a cluster's weight, b that at or below a quantile. */
struct below_sums {
    double a, a2, b, b2, ab;
};

static void add_below(const struct rmap_stats_block *block, size_t first, size_t end,
                      const double *value, const double *quantile, size_t n,
                      struct below_sums *sums)
{
    double a = 0.0;
    for (size_t k = first; k < end; k++)
        a += rmap_stats_weight(block, k);
    for (size_t j = 0; j < n; j++) {
        double b = 0.0;
        for (size_t k = first; k < end; k++)
            if (value[k] <= quantile[j])
                b += rmap_stats_weight(block, k);
        sums[j].a += a;
        sums[j].b += b;
        sums[j].a2 += rmap_stats_rounded(a * a);
        sums[j].b2 += rmap_stats_rounded(b * b);
        sums[j].ab += rmap_stats_rounded(a * b);
    }
}

/* Where each ray has one reading of weight 1, b is 0 or 1: sums of it are counts. */
static void below_from_counts(const struct rmap_stats_search *search, const double *quantile,
                              size_t n, struct below_sums *sums)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    for (size_t class = 0; class < setup->n_class; class ++)
        for (size_t j = 0; j < n; j++) {
            const double a =
                rmap_stats_levels_weight(&search->levels, class, search->stats->plan->n_fine);
            const double value = quantile[class / setup->n_source * n + j];
            const double b = isnan(value) ? 0.0 : rmap_stats_search_below(search, class, value);
            sums[class * n + j] = (struct below_sums){a, a, b, b, b};
        }
}

/* Standard error of the share of flux at or below a quantile, from its classes' sums. */
static double share_error(const struct rmap_stats_setup *setup, const struct below_sums *sums,
                          size_t n)
{
    const double *flux_per_weight = rmap_map_flux_per_weight(setup->quantities->map);
    const double *emitted = rmap_map_emitted(setup->quantities->map);
    double flux = 0.0, below = 0.0, variance = 0.0;
    for (size_t s = 0; s < setup->n_source; s++) {
        flux += flux_per_weight[s] * sums[s * n].a;
        below += flux_per_weight[s] * sums[s * n].b;
    }
    const double r = below / flux;
    for (size_t s = 0; s < setup->n_source; s++) {
        const struct below_sums *own = &sums[s * n];
        double z = own->b - r * own->a, z2 = own->b2 - 2.0 * r * own->ab + r * r * own->a2;
        double f = flux_per_weight[s] / flux, many = emitted[s];
        if (own->a > 0.0)
            variance +=
                many < 2.0 ? (double)NAN : f * f * many / (many - 1.0) * (z2 - z * z / many);
    }
    return isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0));
}

static bool is_counted(const struct rmap_stats *stats)
{
    return stats->known.n_several == 0 && !stats->known.any_weight;
}

/* ends: [n_group][2 n]; the shares p - e and p + e of every quantile, NaN where e is not known. */
static enum rmap_status find_ends(const struct rmap_stats_search *search, const double *quantile,
                                  double *ends, struct rmap_error *err)
{
    const struct rmap_stats *stats = search->stats;
    const struct rmap_stats_setup *setup = stats->setup;
    const size_t n = stats->n_quantile;
    const bool counted = is_counted(stats);
    const bool known = search->in_memory || counted;
    struct below_sums *sums = rmap_alloc(setup->n_class * n + 1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles' errors");
    for (size_t part = 0; !counted && part < search->gathered->n_part; part++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(search->gathered, part);
        for (size_t first = 0, end = 0; first < block.n; first = end) {
            end = rmap_stats_cluster_end(&block, first);
            size_t class = block.tag ? rmap_stats_class(block.tag[first]) : block.run->class;
            add_below(&block, first, end, block.value[search->quantity],
                      quantile + class / setup->n_source * n, n, sums + class * n);
        }
    }
    if (counted)
        below_from_counts(search, quantile, n, sums);
    for (size_t g = 0; g < setup->n_group; g++)
        for (size_t j = 0; j < n; j++) {
            double error =
                known ? share_error(setup, sums + g * setup->n_source * n + j, n) : (double)NAN;
            ends[(g * n + j) * 2] = fmax(stats->p[j] - error, 0.0) + 0.0 * error;
            ends[(g * n + j) * 2 + 1] = fmin(stats->p[j] + error, 1.0) + 0.0 * error;
        }
    rmap_free(sums);
    return RMAP_OK;
}

/* Shares to be looked for: p, and about where its ends will be, so that readings are listed once.
 * Scratch as for `find`. */
static enum rmap_status foresee(struct rmap_stats_search *search, double *quantile, double *ends,
                                double *weight, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats *stats = search->stats;
    const size_t n = stats->n_quantile;
    for (size_t k = 0; k < stats->n_group * n; k++)
        ends[k] = stats->p[k % n];
    RMAP_TRY(rmap_stats_search_want(search, ends, n, err));
    if (!search->in_memory || !is_counted(stats))
        return RMAP_OK;
    for (size_t k = 0; k < stats->n_group * n; k++)
        quantile[k] = rmap_stats_search_at(search, k / n, stats->p[k % n], weight);
    RMAP_TRY(find_ends(search, quantile, ends, err));
    st = rmap_stats_search_want(search, ends, 2 * n, err);
out:
    return st;
}

/* Quantiles of one quantity. quantile [n_group][n], ends [n_group][2 n], weight [n_source]. */
static enum rmap_status find(struct rmap_stats_search *search, double *quantile, double *ends,
                             double *weight, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats *stats = search->stats;
    const size_t n_group = stats->n_group, n = stats->n_quantile;
    RMAP_TRY(foresee(search, quantile, ends, weight, err));
    RMAP_TRY(rmap_stats_search_fill(search, err));
    for (size_t k = 0; k < n_group * n; k++)
        quantile[k] = rmap_stats_search_at(search, k / n, stats->p[k % n], weight);
    RMAP_TRY(find_ends(search, quantile, ends, err));
    RMAP_TRY(rmap_stats_search_want(search, ends, 2 * n, err));
    RMAP_TRY(rmap_stats_search_fill(search, err));
    for (size_t k = 0; k < n_group * n; k++) {
        double error = (double)NAN;
        if (!isnan(ends[2 * k]) && !isnan(quantile[k]))
            error = 0.5 * (rmap_stats_search_at(search, k / n, ends[2 * k + 1], weight) -
                           rmap_stats_search_at(search, k / n, ends[2 * k], weight));
        stats->group[k / n].of[search->quantity].quantile[k % n] =
            (struct rmap_stats_estimate){quantile[k], error};
    }
out:
    return st;
}

enum rmap_status rmap_stats_find_quantiles(struct rmap_stats *stats,
                                           const struct rmap_stats_gathered *gathered,
                                           const struct rmap_stats_sums *sums, int n_thread,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_plan *plan = stats->plan;
    const size_t n = stats->n_group * stats->n_quantile;
    double *memory = rmap_alloc(3 * n + stats->setup->n_source + 1, sizeof *memory);
    if (!memory)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t i = 0; i < stats->setup->quantities->n && st == RMAP_OK && n > 0; i++) {
        struct rmap_stats_search search = {.stats = stats,
                                           .sums = sums,
                                           .gathered = gathered,
                                           .in_memory = !gathered->known.dropped,
                                           .n_thread = n_thread,
                                           .quantity = i};
        bool whole = stats->setup->quantities->of[i].is_whole && plan->fine_per[i] == 1.0;
        if (!search.in_memory && !whole && plan->fine_per[i] > 0.0)
            stats->resolution[i] = 1.0 / plan->fine_per[i];
        st = rmap_stats_search_init(&search, err);
        if (st == RMAP_OK)
            st = find(&search, memory, memory + n, memory + 3 * n, err);
        rmap_stats_search_fini(&search);
    }
    rmap_free(memory);
    return st;
}
