/* SPDX-License-Identifier: MIT
 *
 * Quantiles: the least value with at least a share p of the flux at or below it. The fine
 * histogram says in which of its bins that value lies; with the readings in memory, those of the
 * few bins of interest are sorted and tell it exactly; without, it is interpolated in the bin.
 */
#include <math.h>
#include <stdlib.h>

#include "analysis/stats.h"
#include "base/alloc.h"

/* Shares within this of each other are equal: sums of fluxes of several sources are rounded. */
static const double SHARE_SLACK = 1e-12;

struct item {
    double value, weight;
    uint32_t source;
    uint32_t list;
};

/* A fine bin that some quantile lies in: what is in it. */
struct list {
    double least, greatest;
    size_t first, n; /* of the items */
};

/* One quantity of all groups. */
struct search {
    const struct rmap_stats *stats;
    const struct rmap_stats_sums *sums;
    struct rmap_stats_block block; /* no readings: not in memory */
    bool in_memory;
    size_t quantity;
    double *below;   /* [n_group][n_fine + 1] flux in the bins before */
    int32_t *of_bin; /* [n_group][n_fine] list, -1: of no interest */
    struct list *list;
    size_t n_list, list_cap;
    struct item *item;
    size_t n_item, item_cap;
};

static void search_fini(struct search *search)
{
    rmap_free(search->below);
    rmap_free(search->of_bin);
    rmap_free(search->list);
    rmap_free(search->item);
}

static const double *fine_of(const struct search *search, size_t g, size_t s)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    size_t row = (g * setup->n_source + s) * setup->quantities->n + search->quantity;
    return search->sums->fine + row * search->stats->plan->n_fine;
}

static enum rmap_status search_init(struct search *search, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t n_fine = search->stats->plan->n_fine;
    const double *flux_per_weight = rmap_map_flux_per_weight(setup->quantities->map);
    search->below = rmap_alloc(setup->n_group * (n_fine + 1), sizeof *search->below);
    search->of_bin = rmap_alloc(setup->n_group * n_fine, sizeof *search->of_bin);
    if (!search->below || !search->of_bin)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t g = 0; g < setup->n_group; g++) {
        double *below = search->below + g * (n_fine + 1);
        for (size_t s = 0; s < setup->n_source; s++) {
            const double *fine = fine_of(search, g, s);
            double weight = 0.0;
            for (size_t k = 0; k < n_fine; k++) {
                weight += fine[k]; /* exact, so that a bin without light adds none */
                below[k + 1] += flux_per_weight[s] * weight;
            }
        }
    }
    return RMAP_OK;
}

/* Every fine bin is that of one whole number. */
static bool is_whole(const struct search *search)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    return plan->setup->quantities->of[search->quantity].is_whole &&
           plan->fine_per[search->quantity] == 1.0;
}

/* Fine bin in which a share p of the group's flux is reached; n_fine when it has none. */
static size_t bin_at(const struct search *search, size_t g, double p, double *target_ret)
{
    const size_t n_fine = search->stats->plan->n_fine;
    const double *below = search->below + g * (n_fine + 1);
    const double target = (p - SHARE_SLACK) * below[n_fine];
    size_t low = 0, high = n_fine;
    *target_ret = target;
    if (!(below[n_fine] > 0.0))
        return n_fine;
    while (low < high) { /* first bin whose end reaches it and that has light */
        size_t middle = (low + high) / 2;
        if (below[middle + 1] >= target && below[middle + 1] > 0.0)
            high = middle;
        else
            low = middle + 1;
    }
    return low < n_fine ? low : n_fine - 1;
}

static enum rmap_status want(struct search *search, size_t g, double p, struct rmap_error *err)
{
    double target;
    size_t n_fine = search->stats->plan->n_fine, k = bin_at(search, g, p, &target);
    if (k == n_fine || search->of_bin[g * n_fine + k] >= 0)
        return RMAP_OK;
    void *memory = search->list;
    enum rmap_status st =
        rmap_reserve(&memory, &search->list_cap, search->n_list + 1, sizeof *search->list, err);
    search->list = memory;
    if (st != RMAP_OK)
        return st;
    search->of_bin[g * n_fine + k] = (int32_t)search->n_list;
    search->list[search->n_list++] =
        (struct list){.least = (double)INFINITY, .greatest = -(double)INFINITY};
    return RMAP_OK;
}

/* List that a reading belongs to, or NULL. */
static struct list *list_of(const struct search *search, size_t k)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    size_t g = 0;
    if (plan->setup->n_group > 1)
        g = rmap_stats_class(search->block.tag[k]) / (uint32_t)plan->setup->n_source;
    double value = search->block.value[search->quantity][k];
    int32_t list =
        search->of_bin[g * plan->n_fine + rmap_stats_fine(plan, search->quantity, value)];
    return list < 0 ? NULL : &search->list[list];
}

static int compare_items(const void *a, const void *b)
{
    const struct item *x = a, *y = b;
    if (x->list != y->list)
        return x->list < y->list ? -1 : 1;
    return (x->value > y->value) - (x->value < y->value);
}

/* The least and greatest of every list: where they are equal, nothing need be sorted. */
static void measure_lists(struct search *search)
{
    for (size_t k = 0; k < search->block.n; k++) {
        struct list *list = list_of(search, k);
        double value = search->block.value[search->quantity][k];
        if (!list)
            continue;
        list->least = value < list->least ? value : list->least;
        list->greatest = value > list->greatest ? value : list->greatest;
    }
}

/* Readings of the lists, but of those known to hold one value only; sorted. */
static enum rmap_status fill_lists(struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    search->n_item = 0;
    for (size_t k = 0; k < search->block.n; k++) {
        const struct list *list = list_of(search, k);
        if (!list || list->least == list->greatest)
            continue;
        void *memory = search->item;
        RMAP_TRY(rmap_reserve(&memory, &search->item_cap, search->n_item + 1, sizeof *search->item,
                              err));
        search->item = memory;
        search->item[search->n_item++] =
            (struct item){.value = search->block.value[search->quantity][k],
                          .weight = rmap_stats_weight(&search->block, k),
                          .source = rmap_stats_class(search->block.tag[k]) %
                                    (uint32_t)search->stats->setup->n_source,
                          .list = (uint32_t)(list - search->list)};
    }
    qsort(search->item, search->n_item, sizeof *search->item, compare_items);
    for (size_t first = 0, end; first < search->n_item; first = end) {
        struct list *list = &search->list[search->item[first].list];
        for (end = first;
             end < search->n_item && search->item[end].list == search->item[first].list;)
            end++;
        list->first = first;
        list->n = end - first;
        list->least = search->item[first].value;
        list->greatest = search->item[end - 1].value;
    }
out:
    return st;
}

/* Makes ready for `value_at` of shares p [n_group][n]. */
static enum rmap_status prepare(struct search *search, const double *p, size_t n,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t n_bin = setup->n_group * search->stats->plan->n_fine;
    for (size_t k = 0; k < n_bin; k++)
        search->of_bin[k] = -1;
    search->n_list = 0;
    if (!search->in_memory || is_whole(search))
        return RMAP_OK;
    for (size_t g = 0; g < setup->n_group; g++)
        for (size_t k = 0; k < n; k++)
            RMAP_TRY(want(search, g, p[g * n + k], err));
    if (setup->quantities->of[search->quantity].dimension == RMAP_DIMENSION_WAVELENGTH)
        measure_lists(search); /* few values, which many rays share */
    st = fill_lists(search, err);
out:
    return st;
}

/* In a list whose readings are sorted: the first value at which the flux, `below` before the list,
 * reaches the target. Flux sums up per source, then over sources: the order of equal values does
 * not matter. weight: [n_source] scratch. */
static double value_in_list(const struct search *search, const struct list *list, double below,
                            double target, double *weight)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const double *flux_per_weight = rmap_map_flux_per_weight(setup->quantities->map);
    for (size_t s = 0; s < setup->n_source; s++)
        weight[s] = 0.0;
    for (size_t k = list->first; k < list->first + list->n; k++) {
        const struct item *item = &search->item[k];
        weight[item->source] += item->weight;
        if (k + 1 < list->first + list->n && search->item[k + 1].value == item->value)
            continue;
        double flux = below;
        for (size_t s = 0; s < setup->n_source; s++)
            flux += flux_per_weight[s] * weight[s];
        if (flux >= target)
            return item->value;
    }
    return list->greatest;
}

static double value_at(const struct search *search, size_t g, double p, double *weight)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t n_fine = plan->n_fine, i = search->quantity;
    double target;
    const size_t k = bin_at(search, g, p, &target);
    if (k == n_fine)
        return (double)NAN;
    const double *below = search->below + g * (n_fine + 1);
    if (search->of_bin[g * n_fine + k] >= 0) {
        const struct list *list = &search->list[search->of_bin[g * n_fine + k]];
        return list->least < list->greatest ? value_in_list(search, list, below[k], target, weight)
                                            : list->least;
    }
    if (is_whole(search))
        return plan->fine_low[i] + 0.5 + (double)k;
    if (plan->fine_per[i] == 0.0)
        return plan->fine_low[i];
    double part = (target - below[k]) / (below[k + 1] - below[k]);
    return plan->fine_low[i] + ((double)k + fmin(fmax(part, 0.0), 1.0)) / plan->fine_per[i];
}

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

/* Weight of a source at or below a value of a bin whose readings are in memory; all of it where
 * they are equal, or are not. */
static double part_of_bin(const struct search *search, size_t g, size_t s, size_t bin, double value)
{
    const size_t n_fine = search->stats->plan->n_fine;
    const int32_t index = search->of_bin[g * n_fine + bin];
    const struct list *list = index >= 0 ? &search->list[index] : NULL;
    double weight = 0.0;
    if (!list || !(list->least < list->greatest))
        return fine_of(search, g, s)[bin];
    for (size_t k = list->first; k < list->first + list->n && search->item[k].value <= value; k++)
        weight += search->item[k].source == s ? search->item[k].weight : 0.0;
    return weight;
}

/* Where each ray has one reading of weight 1, b is 0 or 1: sums of it are counts. */
static void below_from_counts(const struct search *search, const double *quantile, size_t n,
                              struct below_sums *sums)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const struct rmap_stats_setup *setup = plan->setup;
    for (size_t class = 0; class < setup->n_class; class ++) {
        const size_t g = class / setup->n_source;
        const double *fine = fine_of(search, g, class % setup->n_source);
        for (size_t j = 0; j < n; j++) {
            double a = 0.0, b = 0.0;
            const double value = quantile[g * n + j];
            size_t last = rmap_stats_fine(plan, search->quantity, value);
            for (size_t k = 0; k < plan->n_fine; k++) {
                a += fine[k];
                b += k < last ? fine[k] : 0.0;
            }
            b += part_of_bin(search, g, class % setup->n_source, last, value);
            sums[class * n + j] = (struct below_sums){a, a, b, b, b};
        }
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

/* ends: [n_group][2 n]; the shares p - e and p + e of every quantile, NaN where e is not known. */
static enum rmap_status find_ends(const struct search *search, const double *quantile, double *ends,
                                  struct rmap_error *err)
{
    const struct rmap_stats *stats = search->stats;
    const struct rmap_stats_setup *setup = stats->setup;
    const size_t n = stats->n_quantile;
    const bool counted = stats->known.n_several == 0 && !stats->known.any_weight;
    const bool known = search->in_memory || counted;
    struct below_sums *sums = rmap_alloc(setup->n_class * n + 1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles' errors");
    const struct rmap_stats_block *block = &search->block;
    for (size_t first = 0, end = 0; !counted && first < block->n; first = end) {
        end = rmap_stats_cluster_end(block, first);
        size_t class = rmap_stats_class(block->tag[first]);
        add_below(block, first, end, block->value[search->quantity],
                  quantile + class / setup->n_source * n, n, sums + class * n);
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

/* Quantiles of one quantity. quantile [n_group][n], ends [n_group][2 n], weight [n_source]. */
static enum rmap_status find(struct search *search, double *quantile, double *ends, double *weight,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats *stats = search->stats;
    const size_t n_group = stats->n_group, n = stats->n_quantile;
    for (size_t k = 0; k < n_group * n; k++)
        ends[k] = stats->p[k % n];
    RMAP_TRY(prepare(search, ends, n, err));
    for (size_t k = 0; k < n_group * n; k++)
        quantile[k] = value_at(search, k / n, stats->p[k % n], weight);
    RMAP_TRY(find_ends(search, quantile, ends, err));
    RMAP_TRY(prepare(search, ends, 2 * n, err));
    for (size_t k = 0; k < n_group * n; k++) {
        double error = (double)NAN;
        if (!isnan(ends[2 * k]) && !isnan(quantile[k]))
            error = 0.5 * (value_at(search, k / n, ends[2 * k + 1], weight) -
                           value_at(search, k / n, ends[2 * k], weight));
        stats->group[k / n].of[search->quantity].quantile[k % n] =
            (struct rmap_stats_estimate){quantile[k], error};
    }
out:
    return st;
}

enum rmap_status rmap_stats_find_quantiles(struct rmap_stats *stats,
                                           const struct rmap_stats_gathered *gathered,
                                           const struct rmap_stats_sums *sums,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_plan *plan = stats->plan;
    const size_t n = stats->n_group * stats->n_quantile;
    double *memory = rmap_alloc(3 * n + stats->setup->n_source + 1, sizeof *memory);
    if (!memory)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t i = 0; i < stats->setup->quantities->n && st == RMAP_OK && n > 0; i++) {
        struct search search = {.stats = stats,
                                .sums = sums,
                                .block = rmap_stats_gathered_block(gathered),
                                .in_memory = !gathered->known.dropped,
                                .quantity = i};
        bool whole = stats->setup->quantities->of[i].is_whole && plan->fine_per[i] == 1.0;
        if (!search.in_memory && !whole && plan->fine_per[i] > 0.0)
            stats->resolution[i] = 1.0 / plan->fine_per[i];
        st = search_init(&search, err);
        if (st == RMAP_OK)
            st = find(&search, memory, memory + n, memory + 3 * n, err);
        search_fini(&search);
    }
    rmap_free(memory);
    return st;
}
