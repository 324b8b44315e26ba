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
    rmap_stats_levels_fini(&search->levels);
    rmap_free(search->of_bin);
    rmap_free(search->windows);
    rmap_free(search->list);
    rmap_free(search->found);
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

/* Finds the readings of lists, but of those known to hold one value only. They are not at hand:
 * what they are is read later, of all at once. */
static enum rmap_status find_items(struct rmap_stats_search *search, const struct chunk *chunk,
                                   struct rmap_error *err)
{
    uint32_t picked[CHUNK];
    int32_t of[CHUNK];
    const size_t n_picked = pick(search, chunk, picked, of);
    void *memory = search->found;
    enum rmap_status st = rmap_reserve(&memory, &search->found_cap, search->n_found + n_picked + 1,
                                       sizeof *search->found, err);
    search->found = memory;
    for (size_t i = 0; st == RMAP_OK && i < n_picked; i++) {
        const size_t k = chunk->first + picked[i];
        const double *at = chunk->block.value[search->quantity] + k;
        if (search->list[of[i]].least == search->list[of[i]].greatest)
            continue;
        __builtin_prefetch(at);
        search->found[search->n_found++] = (struct rmap_stats_found){
            .at = at,
            .weight = rmap_stats_weight(&chunk->block, k),
            .source = (uint32_t)(class_at(chunk, k) % search->stats->setup->n_source),
            .part = (uint32_t)of[i] * RMAP_STATS_PARTS};
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

/* Parts of a list's bin: of two values, the greater one is in the same part or a later one. */
static uint32_t part_of(const struct rmap_stats_search *search, const struct rmap_stats_list *list,
                        double value)
{
    const struct rmap_stats_plan *plan = search->stats->plan;
    const size_t i = search->quantity;
    const double at = (value - plan->fine_low[i]) * plan->fine_per[i] - list->place;
    const double part = at > 0.0 ? at * RMAP_STATS_PARTS : 0.0;
    return (uint32_t)(part < RMAP_STATS_PARTS - 1 ? part : RMAP_STATS_PARTS - 1);
}

/* Reads what was found, in the order of lists and of their parts. */
static enum rmap_status divide_items(struct rmap_stats_search *search, struct rmap_error *err)
{
    const size_t n_part = search->n_list * RMAP_STATS_PARTS;
    size_t *first = rmap_alloc(n_part + 2, sizeof *first);
    struct rmap_stats_item *item = rmap_alloc_unset(search->n_found, sizeof *item);
    rmap_free(search->first);
    rmap_free(search->item);
    search->first = first;
    search->item = item;
    if (!first || !item)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    for (size_t i = 0; i < search->n_found; i++) {
        struct rmap_stats_found *found = &search->found[i];
        struct rmap_stats_list *list = &search->list[found->part / RMAP_STATS_PARTS];
        const double value = *found->at;
        list->least = value < list->least ? value : list->least;
        list->greatest = value > list->greatest ? value : list->greatest;
        found->part += part_of(search, list, value);
        first[found->part + 2]++;
    }
    for (size_t k = 2; k < n_part + 2; k++)
        first[k] += first[k - 1];
    for (size_t i = 0; i < search->n_found; i++) {
        const struct rmap_stats_found *found = &search->found[i];
        item[first[found->part + 1]++] = (struct rmap_stats_item){
            .value = *found->at, .weight = found->weight, .source = found->source};
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
        RMAP_TRY(look_through(search, measure_lists, err)); /* few values, of many rays each */
    search->n_found = 0;
    RMAP_TRY(look_through(search, find_items, err));
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
