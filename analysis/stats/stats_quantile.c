/* SPDX-License-Identifier: MIT
 *
 * Quantiles: the least value with at least a share p of the flux at or below it, and their errors.
 * The fine histogram says in which of its bins a share is reached; with the readings in memory,
 * those of the bin are listed and tell it exactly; without, it is interpolated.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "analysis/stats/stats.h"
#include "analysis/stats/stats_quantile.h"
#include "base/alloc.h"

/* Shares within this of each other are equal: sums of fluxes of several sources are rounded. */
static const double SHARE_SLACK = 1e-12;

/* A reading in a listed bin; of the same value and source as the one before: their sum. */
struct item {
    double value, weight;
    uint32_t list, source;
};

/* The search for one quantity, in all groups. */
struct search {
    const struct rmap_stats *stats;
    const struct rmap_stats_gathered *gathered;
    size_t quantity;
    bool in_memory;
    double *below;    /* [n_class][n_fine + 1] weight in the fine bins before each */
    int32_t *list_of; /* [n_group][n_fine] list of a fine bin; -1: none */
    size_t n_list, n_filled;
    struct item *item; /* [n_item] by list, then value */
    size_t n_item, item_cap;
    size_t *first; /* [n_filled + 1] item of each list */
    size_t first_cap;
};

/* Of a group's sources. */
static const double *flux_per_weight(const struct rmap_stats_setup *setup, size_t g)
{
    return rmap_map_flux_per_weight(setup->quantities->map) + rmap_stats_setup_source(setup, g, 0);
}

static bool bins_are_whole(const struct search *search)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    return plan->setup->quantities->of[search->quantity].is_whole &&
           plan->fine_per[search->quantity] == 1.0;
}

/* Weight of a class in the fine bins before k. */
static double weight_below(const struct search *search, size_t class, size_t k)
{
    return search->below[class * (search->stats->plan->n_fine + 1) + k];
}

/* Flux of a group in the fine bins before k. */
static double flux_below(const struct search *search, size_t g, size_t k)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    double flux = 0.0;
    for (size_t s = 0; s < setup->n_source; s++)
        flux += flux_per_weight(setup, g)[s] * weight_below(search, g * setup->n_source + s, k);
    return flux;
}

/* Fine bin in which a share p of the group's flux is reached; n_fine when it has none. */
static size_t bin_at(const struct search *search, size_t g, double p, double *target_ret)
{
    const size_t n_fine = search->stats->plan->n_fine;
    const double flux = flux_below(search, g, n_fine);
    size_t low = 0, high = n_fine - 1;
    *target_ret = fmax((p - SHARE_SLACK) * flux, DBL_MIN); /* empty bins reach nothing */
    if (!(flux > 0.0) || isnan(p))
        return n_fine;
    while (low < high) { /* it is in [low, high] */
        const size_t middle = low + (high - low) / 2;
        if (flux_below(search, g, middle + 1) >= *target_ret)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static void search_fini(struct search *search)
{
    rmap_free(search->below);
    rmap_free(search->list_of);
    rmap_free(search->item);
    rmap_free(search->first);
}

static enum rmap_status search_init(struct search *search, const struct rmap_stats_sums *sums,
                                    struct rmap_error *err)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const struct rmap_stats_setup *setup = plan->setup;
    const size_t n_fine = plan->n_fine, n_bin = setup->n_group * n_fine;
    search->below = rmap_alloc_unset(setup->n_class * (n_fine + 1), sizeof *search->below);
    search->list_of = rmap_alloc_unset(n_bin, sizeof *search->list_of);
    if (!search->below || !search->list_of)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t k = 0; k < n_bin; k++)
        search->list_of[k] = -1;
    for (size_t class = 0; class < setup->n_class; class ++) {
        const double *fine =
            sums->fine + (class * setup->quantities->n + search->quantity) * n_fine;
        double *below = search->below + class * (n_fine + 1);
        below[0] = 0.0;
        for (size_t k = 0; k < n_fine; k++)
            below[k + 1] = below[k] + fine[k];
    }
    return RMAP_OK;
}

/* Lists the bins in which shares p [n_group][n] are reached, where that says more; NaN is none. */
static void want(struct search *search, const double *p, size_t n)
{
    const size_t n_fine = search->stats->plan->n_fine;
    if (!search->in_memory || bins_are_whole(search))
        return;
    for (size_t k = 0; k < search->stats->n_group * n; k++) {
        double target;
        const size_t bin = bin_at(search, k / n, p[k], &target);
        if (bin < n_fine && search->list_of[k / n * n_fine + bin] < 0)
            search->list_of[k / n * n_fine + bin] = (int32_t)search->n_list++;
    }
}

/* Adds a block's readings of lists that are not filled. last: [lists to fill][n_source] the item
 * before of the same list and source. */
static enum rmap_status list_readings(struct search *search, const struct rmap_stats_block *block,
                                      size_t *last, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t n_source = plan->setup->n_source;
    const double *value = block->value[search->quantity];
    for (size_t k = 0; k < block->n; k++) {
        const size_t class = rmap_stats_class(block, k), source = class % n_source;
        const int32_t list = search->list_of[class / n_source * plan->n_fine +
                                             rmap_stats_fine(plan, search->quantity, value[k])];
        if (list < 0 || (size_t)list < search->n_filled)
            continue;
        size_t *before = &last[((size_t)list - search->n_filled) * n_source + source];
        if (*before < search->n_item && search->item[*before].value == value[k]) {
            search->item[*before].weight += rmap_stats_weight(block, k);
            continue;
        }
        RMAP_TRY(RMAP_RESERVE(search->item, search->item_cap, search->n_item + 1, err));
        *before = search->n_item;
        search->item[search->n_item++] =
            (struct item){value[k], rmap_stats_weight(block, k), (uint32_t)list, (uint32_t)source};
    }
out:
    return st;
}

static int compare_items(const void *a, const void *b)
{
    const struct item *x = a, *y = b;
    return x->list != y->list ? (x->list > y->list) - (x->list < y->list)
                              : (x->value > y->value) - (x->value < y->value);
}

/* Fills the lists that are not. */
static enum rmap_status fill(struct search *search, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_source = search->stats->setup->n_source, before = search->n_item;
    const size_t n_last = (search->n_list - search->n_filled) * n_source;
    size_t *last = NULL;
    if (n_last == 0)
        return RMAP_OK;
    last = rmap_alloc_unset(n_last, sizeof *last);
    if (!last)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t k = 0; k < n_last; k++)
        last[k] = SIZE_MAX;
    for (size_t p = 0; p < search->gathered->n_part; p++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(search->gathered, p);
        RMAP_TRY(list_readings(search, &block, last, err));
    }
    qsort(search->item + before, search->n_item - before, sizeof *search->item, compare_items);
    RMAP_TRY(RMAP_RESERVE(search->first, search->first_cap, search->n_list + 1, err));
    for (size_t list = search->n_filled, k = before; list <= search->n_list; list++) {
        while (k < search->n_item && search->item[k].list < list)
            k++;
        search->first[list] = k;
    }
    search->n_filled = search->n_list;
out:
    rmap_free(last);
    return st;
}

/* Items of a fine bin of a group; *n_ret 0: it is not listed. */
static const struct item *items_of(const struct search *search, size_t g, size_t bin, size_t *n_ret)
{
    const int32_t list = search->list_of[g * search->stats->plan->n_fine + bin];
    *n_ret = 0;
    if (list < 0 || (size_t)list >= search->n_filled)
        return NULL;
    *n_ret = search->first[list + 1] - search->first[list];
    return search->item + search->first[list];
}

/* The first value of a group's items at which the flux, `below` before them, reaches the target.
 * weight: [n_source] scratch. */
static double value_in(const struct search *search, size_t g, const struct item *item, size_t n,
                       double below, double target, double *weight)
{
    const size_t n_source = search->stats->setup->n_source;
    const double *per_weight = flux_per_weight(search->stats->setup, g);
    for (size_t s = 0; s < n_source; s++)
        weight[s] = 0.0;
    for (size_t k = 0; k < n; k++) {
        double flux = below;
        weight[item[k].source] += item[k].weight;
        if (k + 1 < n && item[k + 1].value == item[k].value)
            continue;
        for (size_t s = 0; s < n_source; s++)
            flux += per_weight[s] * weight[s];
        if (flux >= target)
            return item[k].value;
    }
    return item[n - 1].value;
}

/* Least value with a share p of the group's flux at or below it; interpolated where its bin is not
 * listed. weight: [n_source] scratch. */
static double value_at(const struct search *search, size_t g, double p, double *weight)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t i = search->quantity;
    double target;
    size_t n;
    const size_t k = bin_at(search, g, p, &target);
    if (k == plan->n_fine)
        return (double)NAN;
    const double below = flux_below(search, g, k);
    const struct item *item = items_of(search, g, k, &n);
    if (n > 0)
        return value_in(search, g, item, n, below, target, weight);
    if (bins_are_whole(search))
        return plan->fine_low[i] + 0.5 + (double)k;
    if (plan->fine_per[i] == 0.0)
        return plan->fine_low[i];
    const double part = (target - below) / (flux_below(search, g, k + 1) - below);
    return plan->fine_low[i] + ((double)k + fmin(fmax(part, 0.0), 1.0)) / plan->fine_per[i];
}

/* Weight of a class at or below a value: of its bin, all where that is not listed. */
static double weight_up_to(const struct search *search, size_t class, double value)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t bin = rmap_stats_fine(search->stats->plan, search->quantity, value);
    size_t n;
    const struct item *item = items_of(search, class / setup->n_source, bin, &n);
    double weight = weight_below(search, class, n > 0 ? bin : bin + 1);
    for (size_t k = 0; k < n && item[k].value <= value; k++)
        weight += item[k].source == class % setup->n_source ? item[k].weight : 0.0;
    return weight;
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

/* Where each ray has one reading of weight 1, b is 0 or 1: sums of it are counts. */
static void below_from_counts(const struct search *search, const double *quantile, size_t n,
                              struct below_sums *sums)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    for (size_t class = 0; class < setup->n_class; class ++)
        for (size_t j = 0; j < n; j++) {
            const double a = weight_below(search, class, search->stats->plan->n_fine);
            const double value = quantile[class / setup->n_source * n + j];
            const double b = isnan(value) ? 0.0 : weight_up_to(search, class, value);
            sums[class * n + j] = (struct below_sums){a, a, b, b, b};
        }
}

/* Standard error of the share of a group's flux at or below a quantile, from its classes' sums. */
static double share_error(const struct rmap_stats_setup *setup, size_t g,
                          const struct below_sums *sums, size_t n)
{
    const double *per_weight = flux_per_weight(setup, g);
    const double *emitted =
        rmap_map_emitted(setup->quantities->map) + rmap_stats_setup_source(setup, g, 0);
    double flux = 0.0, below = 0.0, variance = 0.0;
    for (size_t s = 0; s < setup->n_source; s++) {
        flux += per_weight[s] * sums[s * n].a;
        below += per_weight[s] * sums[s * n].b;
    }
    const double r = below / flux;
    for (size_t s = 0; s < setup->n_source; s++) {
        const struct below_sums *own = &sums[s * n];
        double z = own->b - r * own->a, z2 = own->b2 - 2.0 * r * own->ab + r * r * own->a2;
        double f = per_weight[s] / flux, many = emitted[s];
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
    struct below_sums *sums = rmap_alloc(setup->n_class * n + 1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles' errors");
    for (size_t part = 0; !counted && part < search->gathered->n_part; part++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(search->gathered, part);
        for (size_t first = 0, end = 0; first < block.n; first = end) {
            const size_t class = rmap_stats_class(&block, first);
            end = rmap_stats_cluster_end(&block, first);
            add_below(&block, first, end, block.value[search->quantity],
                      quantile + class / setup->n_source * n, n, sums + class * n);
        }
    }
    if (counted)
        below_from_counts(search, quantile, n, sums);
    for (size_t k = 0; k < setup->n_group * n; k++) {
        const struct below_sums *own = sums + k / n * setup->n_source * n + k % n;
        const double error =
            search->in_memory || counted ? share_error(setup, k / n, own, n) : (double)NAN;
        ends[2 * k] = fmax(stats->p[k % n] - error, 0.0) + 0.0 * error;
        ends[2 * k + 1] = fmin(stats->p[k % n] + error, 1.0) + 0.0 * error;
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
    want(search, ends, n);
    RMAP_TRY(fill(search, err));
    for (size_t k = 0; k < n_group * n; k++)
        quantile[k] = value_at(search, k / n, stats->p[k % n], weight);
    RMAP_TRY(find_ends(search, quantile, ends, err));
    want(search, ends, 2 * n);
    RMAP_TRY(fill(search, err));
    for (size_t k = 0; k < n_group * n; k++) {
        double error = (double)NAN;
        if (stats->group[k / n].n_ray > 1 && !isnan(ends[2 * k]) && !isnan(quantile[k]))
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
                                .gathered = gathered,
                                .in_memory = !gathered->known.dropped,
                                .quantity = i};
        if (!search.in_memory && !bins_are_whole(&search) && plan->fine_per[i] > 0.0)
            stats->resolution[i] = 1.0 / plan->fine_per[i];
        st = search_init(&search, sums, err);
        if (st == RMAP_OK)
            st = find(&search, memory, memory + n, memory + 3 * n, err);
        search_fini(&search);
    }
    rmap_free(memory);
    return st;
}
