/* SPDX-License-Identifier: MIT */
#include "analysis/stats_search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/stats_places.h"
#include "base/alloc.h"

/* Shares within this of each other are equal: sums of fluxes of several sources are rounded. */
static const double SHARE_SLACK = 1e-12;

/* Readings looked at at once. */
enum { CHUNK = 1024 };

void rmap_stats_search_fini(struct rmap_stats_search *search)
{
    rmap_free(search->below);
    rmap_free(search->before);
    rmap_free(search->of_bin);
    rmap_free(search->windows);
    rmap_free(search->list);
    rmap_free(search->item);
}

static const double *before_of(const struct rmap_stats_search *search, size_t class)
{
    return search->before + class * (search->stats->plan->n_fine + 1);
}

static void sum_up(struct rmap_stats_search *search, size_t class)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t n_fine = search->stats->plan->n_fine;
    const size_t row = (class * setup->quantities->n + search->quantity) * n_fine;
    const double *fine = search->sums->fine ? search->sums->fine + row : NULL;
    const uint32_t *single = search->sums->fine_single + row;
    const double flux = rmap_map_flux_per_weight(setup->quantities->map)[class % setup->n_source];
    double *before = search->before + class * (n_fine + 1);
    double *below = search->below + class / setup->n_source * (n_fine + 1);
    for (size_t k = 0; k < n_fine; k++) {
        before[k + 1] =
            before[k] +
            (single[k] + (fine ? fine[k] : 0.0)); /* exact, so that a bin without light adds none */
        below[k + 1] += flux * before[k + 1];
    }
}

enum rmap_status rmap_stats_search_init(struct rmap_stats_search *search, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const size_t n_fine = search->stats->plan->n_fine, n_bin = setup->n_group * n_fine;
    search->below = rmap_alloc(setup->n_group * (n_fine + 1), sizeof *search->below);
    search->before = rmap_alloc(setup->n_class * (n_fine + 1), sizeof *search->before);
    search->of_bin = rmap_alloc(n_bin, sizeof *search->of_bin);
    search->windows = rmap_alloc(setup->n_group, sizeof *search->windows);
    if (!search->below || !search->before || !search->of_bin || !search->windows)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t k = 0; k < n_bin; k++)
        search->of_bin[k] = -1;
    for (size_t class = 0; class < setup->n_class; class ++)
        sum_up(search, class);
    return RMAP_OK;
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
    search->list[search->n_list++] = (struct rmap_stats_list){.bin = g * n_fine + k};
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

/* Readings that are looked at together. */
struct chunk {
    struct rmap_stats_block block;
    size_t first, n; /* n <= CHUNK */
};

static size_t class_at(const struct chunk *chunk, size_t k)
{
    const struct rmap_stats_block *block = &chunk->block;
    return block->tag ? rmap_stats_class(block->tag[k]) : block->run->class;
}

/* Those that belong to a list, and to which. Returns how many. */
static size_t pick(const struct rmap_stats_search *search, const struct chunk *chunk,
                   uint32_t *picked, int32_t *list)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const struct rmap_stats_block *block = &chunk->block;
    const uint16_t *place = block->place[search->quantity];
    uint16_t own[CHUNK];
    size_t n_picked = 0;
    if (place)
        place += chunk->first;
    else
        rmap_stats_fine_places(plan, search->quantity,
                               block->value[search->quantity] + chunk->first, chunk->n, own);
    place = place ? place : own;
    const bool one_group = !block->tag || plan->setup->n_group == 1;
    const size_t group = one_group ? class_at(chunk, chunk->first) / plan->setup->n_source : 0;
    static const struct rmap_stats_windows none = {.n = 0};
    const size_t n_near = rmap_stats_windows_pick(one_group ? &search->windows[group] : &none,
                                                  place, chunk->n, picked);
    for (size_t i = 0; i < n_near; i++) {
        const size_t k = picked[i];
        const size_t its =
            one_group ? group : class_at(chunk, chunk->first + k) / plan->setup->n_source;
        list[n_picked] = search->of_bin[its * plan->n_fine + place[k]];
        picked[n_picked] = (uint32_t)k;
        n_picked += list[n_picked] >= 0;
    }
    return n_picked;
}

/* The least and greatest of every list: where they are equal, nothing need be sorted. */
static enum rmap_status measure_lists(struct rmap_stats_search *search, const struct chunk *chunk,
                                      struct rmap_error *err)
{
    uint32_t picked[CHUNK];
    int32_t of[CHUNK];
    const size_t n_picked = pick(search, chunk, picked, of);
    (void)err;
    for (size_t i = 0; i < n_picked; i++) {
        struct rmap_stats_list *list = &search->list[of[i]];
        double value = chunk->block.value[search->quantity][chunk->first + picked[i]];
        list->least = value < list->least ? value : list->least;
        list->greatest = value > list->greatest ? value : list->greatest;
    }
    return RMAP_OK;
}

/* Adds the readings of lists, but of those known to hold one value only. */
static enum rmap_status add_items(struct rmap_stats_search *search, const struct chunk *chunk,
                                  struct rmap_error *err)
{
    uint32_t picked[CHUNK];
    int32_t of[CHUNK];
    const size_t n_picked = pick(search, chunk, picked, of);
    void *memory = search->item;
    enum rmap_status st = rmap_reserve(&memory, &search->item_cap, search->n_item + n_picked + 1,
                                       sizeof *search->item, err);
    search->item = memory;
    for (size_t i = 0; st == RMAP_OK && i < n_picked; i++) {
        const size_t k = chunk->first + picked[i];
        if (search->list[of[i]].least == search->list[of[i]].greatest)
            continue;
        search->item[search->n_item++] = (struct rmap_stats_item){
            .value = chunk->block.value[search->quantity][k],
            .weight = rmap_stats_weight(&chunk->block, k),
            .source = (uint32_t)(class_at(chunk, k) % search->stats->setup->n_source),
            .list = (uint32_t)of[i]};
    }
    return st;
}

/* All readings in memory, chunk by chunk. */
static enum rmap_status look_through(struct rmap_stats_search *search,
                                     enum rmap_status (*look)(struct rmap_stats_search *search,
                                                              const struct chunk *chunk,
                                                              struct rmap_error *err),
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t p = 0; p < search->gathered->n_part; p++) {
        struct chunk chunk = {.block = rmap_stats_gathered_block(search->gathered, p)};
        for (; st == RMAP_OK && chunk.first < chunk.block.n; chunk.first += CHUNK) {
            const size_t rest = chunk.block.n - chunk.first;
            chunk.n = rest < CHUNK ? rest : CHUNK;
            st = look(search, &chunk, err);
        }
    }
    return st;
}

/* Puts the items in the order of their lists. */
static enum rmap_status divide_items(struct rmap_stats_search *search, struct rmap_error *err)
{
    struct rmap_stats_item *item = rmap_alloc_unset(search->n_item, sizeof *item);
    if (!item)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    size_t first = 0;
    for (size_t i = 0; i < search->n_item; i++)
        search->list[search->item[i].list].n++;
    for (size_t k = 0; k < search->n_list; first += search->list[k++].n)
        search->list[k].first = first;
    for (size_t i = 0; i < search->n_item; i++)
        item[search->list[search->item[i].list].first++] = search->item[i];
    for (size_t k = 0; k < search->n_list; k++) {
        struct rmap_stats_list *list = &search->list[k];
        list->first -= list->n;
        for (size_t i = list->first; i < list->first + list->n; i++) {
            list->least = item[i].value < list->least ? item[i].value : list->least;
            list->greatest = item[i].value > list->greatest ? item[i].value : list->greatest;
        }
    }
    rmap_free(search->item);
    search->item = item;
    search->item_cap = search->n_item;
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
    for (size_t i = 0; i < search->n_list; i++)
        search->list[i] = (struct rmap_stats_list){
            .bin = search->list[i].bin, .least = (double)INFINITY, .greatest = -(double)INFINITY};
    lay_windows(search);
    if (setup->quantities->of[search->quantity].dimension == RMAP_DIMENSION_WAVELENGTH)
        RMAP_TRY(look_through(search, measure_lists, err)); /* few values, of many rays each */
    search->n_item = 0;
    RMAP_TRY(look_through(search, add_items, err));
    RMAP_TRY(divide_items(search, err));
    search->n_filled = search->n_list;
out:
    return st;
}

/* In a list: the first value at which the flux, `below` before the list, reaches the target.
 * weight: [n_source] scratch. */
static double value_in_list(const struct rmap_stats_search *search,
                            const struct rmap_stats_list *list, double below, double target,
                            double *weight)
{
    const struct rmap_stats_setup *setup = search->stats->setup;
    const struct rmap_stats_flux flux = {.per_weight =
                                             rmap_map_flux_per_weight(setup->quantities->map),
                                         .n_source = setup->n_source,
                                         .below = below,
                                         .target = target};
    return rmap_stats_items_at(search->item + list->first, list->n, &flux, weight);
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
    const double *below = search->below + g * (n_fine + 1);
    const int32_t index = search->of_bin[g * n_fine + k];
    if (index >= 0 && (size_t)index < search->n_filled) {
        const struct rmap_stats_list *list = &search->list[index];
        return list->least < list->greatest ? value_in_list(search, list, below[k], target, weight)
                                            : list->least;
    }
    if (rmap_stats_search_is_whole(search))
        return plan->fine_low[i] + 0.5 + (double)k;
    if (plan->fine_per[i] == 0.0)
        return plan->fine_low[i];
    double part = (target - below[k]) / (below[k + 1] - below[k]);
    return plan->fine_low[i] + ((double)k + fmin(fmax(part, 0.0), 1.0)) / plan->fine_per[i];
}

double rmap_stats_search_below(const struct rmap_stats_search *search, size_t class, double value)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t g = class / plan->setup->n_source, s = class % plan->setup->n_source;
    const size_t bin = rmap_stats_fine(plan, search->quantity, value);
    const double *before = before_of(search, class);
    const int32_t index = search->of_bin[g * plan->n_fine + bin];
    if (index < 0 || (size_t)index >= search->n_filled)
        return before[bin + 1];
    const struct rmap_stats_list *list = &search->list[index];
    if (!(list->least < list->greatest))
        return before[bin + 1];
    double weight = before[bin];
    for (size_t k = list->first; k < list->first + list->n; k++) {
        const struct rmap_stats_item *item = &search->item[k];
        weight += item->source == s && item->value <= value ? item->weight : 0.0;
    }
    return weight;
}
