/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_find.h"

#include <stdatomic.h>
#include <string.h>

#include "analysis/stats/stats_places.h"
#include "base/alloc.h"
#include "base/workers.h"

/* Readings looked at at once; and so many that another thread is worth starting. */
enum { CHUNK = 1024, READINGS_OF_THREAD = 1 << 18 };

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

/* Readings of parts [first, last) in memory, chunk by chunk. */
static enum rmap_status look_through(
    const struct rmap_stats_search *search, size_t first, size_t last, void *context,
    enum rmap_status (*look)(const struct rmap_stats_search *search, const struct chunk *chunk,
                             void *context, struct rmap_error *err),
    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t p = first; p < last; p++) {
        struct chunk chunk = {.block = rmap_stats_gathered_block(search->gathered, p)};
        for (; st == RMAP_OK && chunk.first < chunk.block.n; chunk.first += CHUNK) {
            const size_t rest = chunk.block.n - chunk.first;
            chunk.n = rest < CHUNK ? rest : CHUNK;
            st = look(search, &chunk, context, err);
        }
    }
    return st;
}

/* context: the lists. */
static enum rmap_status measure_chunk(const struct rmap_stats_search *search,
                                      const struct chunk *chunk, void *context,
                                      struct rmap_error *err)
{
    uint32_t picked[CHUNK];
    int32_t of[CHUNK];
    const size_t n_picked = pick(search, chunk, picked, of);
    struct rmap_stats_list *lists = context;
    (void)err;
    for (size_t i = 0; i < n_picked; i++) {
        struct rmap_stats_list *list = &lists[of[i]];
        const double value = chunk->block.value[search->quantity][chunk->first + picked[i]];
        list->least = value < list->least ? value : list->least;
        list->greatest = value > list->greatest ? value : list->greatest;
    }
    return RMAP_OK;
}

void rmap_stats_measure_lists(struct rmap_stats_search *search)
{
    (void)look_through(search, 0, search->gathered->n_part, search->list, measure_chunk, NULL);
}

/* Finds the readings of lists, but of those known to hold one value only. They are not at hand:
 * what they are is read later, of all at once. context: a share of the findings. */
static enum rmap_status find_in_chunk(const struct rmap_stats_search *search,
                                      const struct chunk *chunk, void *context,
                                      struct rmap_error *err)
{
    uint32_t picked[CHUNK];
    int32_t of[CHUNK];
    const size_t n_picked = pick(search, chunk, picked, of);
    struct rmap_stats_findings_share *share = context;
    void *memory = share->found;
    enum rmap_status st =
        rmap_reserve(&memory, &share->cap, share->n + n_picked + 1, sizeof *share->found, err);
    share->found = memory;
    for (size_t i = 0; st == RMAP_OK && i < n_picked; i++) {
        const size_t k = chunk->first + picked[i];
        const double *at = chunk->block.value[search->quantity] + k;
        if (search->list[of[i]].least == search->list[of[i]].greatest)
            continue;
        __builtin_prefetch(at);
        share->found[share->n++] = (struct rmap_stats_found){
            .at = at,
            .weight = rmap_stats_weight(&chunk->block, k),
            .source = (uint32_t)(class_at(chunk, k) % search->stats->setup->n_source),
            .part = (uint32_t)of[i] * RMAP_STATS_PARTS};
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

/* Shares that threads take until there is none left. */
struct finding {
    struct rmap_stats_search *search;
    _Atomic size_t next;
};

static void find_shares(void *context, int thread)
{
    struct finding *finding = context;
    struct rmap_stats_search *search = finding->search;
    const size_t n_part = search->gathered->n_part, n = search->findings.n;
    (void)thread;
    for (size_t s = atomic_fetch_add(&finding->next, 1); s < n;
         s = atomic_fetch_add(&finding->next, 1)) {
        struct rmap_stats_findings_share *share = &search->findings.share[s];
        share->n = 0;
        share->status = look_through(search, n_part * s / n, n_part * (s + 1) / n, share,
                                     find_in_chunk, &share->error);
        for (size_t i = 0; i < share->n; i++) {
            struct rmap_stats_found *found = &share->found[i];
            found->value = *found->at;
            found->part +=
                part_of(search, &search->list[found->part / RMAP_STATS_PARTS], found->value);
        }
    }
}

static enum rmap_status reserve_shares(struct rmap_stats_search *search, struct rmap_error *err)
{
    struct rmap_stats_findings *all = &search->findings;
    const size_t most = search->gathered->n / READINGS_OF_THREAD + 1;
    const size_t n_thread = (size_t)search->n_thread;
    if (all->n > 0)
        return RMAP_OK;
    const size_t n = n_thread < most ? n_thread : most;
    all->share = rmap_alloc(n, sizeof *all->share);
    if (!all->share)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for quantiles");
    all->n = n;
    return RMAP_OK;
}

enum rmap_status rmap_stats_find_items(struct rmap_stats_search *search, struct rmap_error *err)
{
    struct rmap_workers *workers = NULL;
    struct rmap_error alone = {0};
    struct finding finding = {.search = search};
    enum rmap_status st = reserve_shares(search, err);
    if (st != RMAP_OK)
        return st;
    const int n_more = (int)search->findings.n - 1;
    if (n_more > 0 &&
        rmap_workers_start(n_more, find_shares, &finding, &workers, &alone) != RMAP_OK)
        workers = NULL; /* this thread finds them all */
    find_shares(&finding, n_more);
    rmap_workers_join(workers);
    for (size_t s = 0; s < search->findings.n && st == RMAP_OK; s++) {
        st = search->findings.share[s].status;
        if (st != RMAP_OK)
            *err = search->findings.share[s].error;
    }
    return st;
}
