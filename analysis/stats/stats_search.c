/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/stats/stats_find.h"
#include "analysis/stats/stats_places.h"
#include "base/alloc.h"

/* Shares within this of each other are equal: sums of fluxes of several sources are rounded. */
static const double SHARE_SLACK = 1e-12;

void rmap_stats_search_fini(struct rmap_stats_search *search)
{
    rmap_stats_levels_fini(&search->levels);
    rmap_free(search->of_bin);
    rmap_free(search->windows);
    rmap_free(search->list);
    for (size_t s = 0; s < search->findings.n; s++)
        rmap_free(search->findings.share[s].found);
    rmap_free(search->findings.share);
    rmap_free(search->first);
    rmap_free(search->item);
}

enum rmap_status rmap_stats_search_init(struct rmap_stats_search *search, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t n_fine = search->stats->plan->n_fine, n_bin = setup->n_group * n_fine;
    search->of_bin = rmap_alloc(n_bin, sizeof *search->of_bin);
    search->windows = rmap_alloc(setup->n_group, sizeof *search->windows);
    if (!search->of_bin || !search->windows)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t k = 0; k < n_bin; k++)
        search->of_bin[k] = -1;
    return rmap_stats_levels_init(&search->levels, search->sums, search->quantity, err);
}

bool rmap_stats_search_is_whole(const struct rmap_stats_search *search)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    return plan->setup->quantities->of[search->quantity].is_whole &&
           plan->fine_per[search->quantity] == 1.0;
}

/* Fine bin in which a share p of the group's flux is reached; n_fine when it has none. */
static size_t bin_at(const struct rmap_stats_search *search, size_t g, double p, double *target_ret)
{
    const size_t n_fine = search->stats->plan->n_fine;
    const double flux = rmap_stats_levels_flux(&search->levels, g, n_fine);
    const double target = (p - SHARE_SLACK) * flux;
    *target_ret = target;
    return flux > 0.0 ? rmap_stats_levels_bin(&search->levels, g, target) : n_fine;
}

static enum rmap_status want_one(struct rmap_stats_search *search, size_t g, double p,
                                 struct rmap_error *err)
{
    double target;
    size_t n_fine = search->stats->plan->n_fine, k = bin_at(search, g, p, &target);
    if (isnan(p) || k == n_fine || search->of_bin[g * n_fine + k] >= 0)
        return RMAP_OK;
    void *memory = search->list;
    enum rmap_status st =
        rmap_reserve(&memory, &search->list_cap, search->n_list + 1, sizeof *search->list, err);
    search->list = memory;
    if (st != RMAP_OK)
        return st;
    search->of_bin[g * n_fine + k] = (int32_t)search->n_list;
    search->list[search->n_list++] =
        (struct rmap_stats_list){.bin = g * n_fine + k, .place = (double)k};
    return RMAP_OK;
}

enum rmap_status rmap_stats_search_want(struct rmap_stats_search *search, const double *p, size_t n,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!search->in_memory || rmap_stats_search_is_whole(search))
        return RMAP_OK;
    for (size_t k = 0; k < search->stats->n_group * n; k++)
        RMAP_TRY(want_one(search, k / n, p[k], err));
out:
    return st;
}

/* Puts what was found in the order of lists and of their parts. */
static enum rmap_status divide_items(struct rmap_stats_search *search, struct rmap_error *err)
{
    const size_t n_part = search->n_list * RMAP_STATS_PARTS;
    const struct rmap_stats_findings *all = &search->findings;
    size_t *first = rmap_alloc(n_part + 2, sizeof *first), n = 0;
    for (size_t s = 0; s < all->n; s++)
        n += all->share[s].n;
    struct rmap_stats_item *item = rmap_alloc_unset(n, sizeof *item);
    rmap_free(search->first);
    rmap_free(search->item);
    search->first = first;
    search->item = item;
    if (!first || !item)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t s = 0; s < all->n; s++)
        for (size_t i = 0; i < all->share[s].n; i++) {
            const struct rmap_stats_found *found = &all->share[s].found[i];
            struct rmap_stats_list *list = &search->list[found->part / RMAP_STATS_PARTS];
            list->least = found->value < list->least ? found->value : list->least;
            list->greatest = found->value > list->greatest ? found->value : list->greatest;
            first[found->part + 2]++;
        }
    for (size_t k = 2; k < n_part + 2; k++)
        first[k] += first[k - 1];
    for (size_t s = 0; s < all->n; s++)
        for (size_t i = 0; i < all->share[s].n; i++) {
            const struct rmap_stats_found *found = &all->share[s].found[i];
            item[first[found->part + 1]++] = (struct rmap_stats_item){
                .value = found->value, .weight = found->weight, .source = found->source};
        }
    return RMAP_OK;
}

static int compare_bins(const void *a, const void *b)
{
    return (int)*(const uint16_t *)a - (int)*(const uint16_t *)b;
}

/* So many lists of a group have windows. */
enum { BINS_FEW = 64 };

/* Windows over the bins with a list; none where there are many. */
static void lay_windows(struct rmap_stats_search *search)
{
    const size_t n_fine = search->stats->plan->n_fine;
    uint16_t bin[BINS_FEW];
    for (size_t g = 0; g < search->stats->n_group; g++) {
        size_t n = 0;
        for (size_t i = 0; i < search->n_list; i++)
            if (search->list[i].bin / n_fine == g && n++ < BINS_FEW)
                bin[n - 1] = (uint16_t)(search->list[i].bin % n_fine);
        search->windows[g].n = 0;
        if (n == 0 || n > BINS_FEW)
            continue;
        qsort(bin, n, sizeof *bin, compare_bins);
        rmap_stats_windows_over(&search->windows[g], bin, n);
    }
}

enum rmap_status rmap_stats_search_fill(struct rmap_stats_search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_setup *setup = search->stats->setup;
    if (search->n_filled == search->n_list)
        return RMAP_OK;
    for (size_t i = 0; i < search->n_list; i++) {
        search->list[i].least = (double)INFINITY;
        search->list[i].greatest = -(double)INFINITY;
    }
    lay_windows(search);
    if (setup->quantities->of[search->quantity].dimension == RMAP_DIMENSION_WAVELENGTH)
        rmap_stats_measure_lists(search); /* few values, of many rays each */
    RMAP_TRY(rmap_stats_find_items(search, err));
    RMAP_TRY(divide_items(search, err));
    search->n_filled = search->n_list;
out:
    return st;
}

/* In a list: the first value at which the flux, `below` before the list, reaches the target.
 * weight: [n_source] scratch. */
static double value_in_list(const struct rmap_stats_search *search, size_t index, double below,
                            double target, double *weight)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const struct rmap_stats_flux flux = {.per_weight =
                                             rmap_map_flux_per_weight(setup->quantities->map),
                                         .n_source = setup->n_source,
                                         .below = below,
                                         .target = target};
    const struct rmap_stats_list *list = &search->list[index];
    if (!(list->least < list->greatest))
        return list->least;
    return rmap_stats_items_at(search->item, search->first + index * RMAP_STATS_PARTS,
                               RMAP_STATS_PARTS, &flux, weight);
}

double rmap_stats_search_at(const struct rmap_stats_search *search, size_t g, double p,
                            double *weight)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t n_fine = plan->n_fine, i = search->quantity;
    double target;
    const size_t k = bin_at(search, g, p, &target);
    if (k == n_fine)
        return (double)NAN;
    const double below = rmap_stats_levels_flux(&search->levels, g, k);
    const int32_t index = search->of_bin[g * n_fine + k];
    if (index >= 0 && (size_t)index < search->n_filled)
        return value_in_list(search, (size_t)index, below, target, weight);
    if (rmap_stats_search_is_whole(search))
        return plan->fine_low[i] + 0.5 + (double)k;
    if (plan->fine_per[i] == 0.0)
        return plan->fine_low[i];
    const double end = rmap_stats_levels_flux(&search->levels, g, k + 1);
    const double part = (target - below) / (end - below);
    return plan->fine_low[i] + ((double)k + fmin(fmax(part, 0.0), 1.0)) / plan->fine_per[i];
}

double rmap_stats_search_below(const struct rmap_stats_search *search, size_t class, double value)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t g = class / plan->setup->n_source, s = class % plan->setup->n_source;
    const size_t bin = rmap_stats_fine(plan, search->quantity, value);
    const int32_t index = search->of_bin[g * plan->n_fine + bin];
    if (index < 0 || (size_t)index >= search->n_filled ||
        !(search->list[index].least < search->list[index].greatest))
        return rmap_stats_levels_weight(&search->levels, class, bin + 1);
    const size_t *first = search->first + (size_t)index * RMAP_STATS_PARTS;
    double weight = rmap_stats_levels_weight(&search->levels, class, bin);
    for (size_t k = first[0]; k < first[RMAP_STATS_PARTS]; k++) {
        const struct rmap_stats_item *item = &search->item[k];
        weight += item->source == s && item->value <= value ? item->weight : 0.0;
    }
    return weight;
}
