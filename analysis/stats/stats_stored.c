/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_stored.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/pick.h"
#include "base/wide.h"
#include "io/map/chunk_cycle.h"

RMAP_WIDE static size_t count_of(const int32_t *source, size_t n, int32_t which)
{
    uint32_t count = 0;
    for (size_t i = 0; i < n; i++)
        count += source[i] == which;
    return count;
}

enum rmap_status rmap_stats_lay_turns(struct rmap_stats_turns *turns,
                                      const struct rmap_cycle *cycle, size_t n,
                                      const int32_t **source_ret, struct rmap_error *err)
{
    const int32_t *source = cycle->element;
    void *block = turns->source;
    const bool are_laid = rmap_cycle_is(&turns->laid, cycle) && turns->n >= n;
    enum rmap_status st = rmap_reserve(&block, &turns->cap, n, sizeof *turns->source, err);
    *source_ret = turns->source = block;
    if (are_laid || st != RMAP_OK)
        return st;
    size_t at = cycle->n < n ? cycle->n : n;
    for (size_t i = 0, k = cycle->phase; i < at; i++) {
        turns->source[i] = source[k];
        k = k + 1 < cycle->n ? k + 1 : 0;
    }
    for (size_t some; at < n; at += some) { /* whole cycles, twice as many each time */
        some = n - at < at ? n - at : at;
        memcpy(turns->source + at, turns->source, some * sizeof *turns->source);
    }
    turns->laid = *cycle;
    turns->n = n;
    return RMAP_OK;
}

void rmap_stats_know_turns(struct rmap_stats_turns *turns, const struct rmap_cycle *cycle,
                           size_t n_source)
{
    if (rmap_cycle_is(&turns->known, cycle))
        return;
    for (size_t s = 0; s < n_source; s++)
        rmap_turns_init(&turns->of[s], cycle->element, cycle->n, cycle->phase, (int32_t)s);
    turns->known = *cycle;
}

static void list_run(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                     int32_t source, size_t end, struct rmap_stats_block *block)
{
    const size_t first = block->n_run > 0 ? reader->run[block->n_run - 1].end : 0;
    if (end > first)
        reader->run[block->n_run++] =
            (struct rmap_stats_run){end, rmap_stats_class_of(setup, source)};
}

/* Puts stored readings in the order of their sources, which take turns, and lists the runs. */
static void pick_turns(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                       size_t n_ray, const double *const *column, double *const *to,
                       struct rmap_stats_block *block)
{
    size_t end = 0;
    for (int32_t s = 0; s < (int32_t)setup->n_source; s++) {
        const size_t first = end;
        for (size_t q = 0; q < setup->quantities->n; q++)
            end = first + rmap_turns_pick(&reader->turns.of[s], column[q], n_ray, to[q] + first);
        list_run(reader, setup, s, end, block);
    }
}

/* Puts stored readings of matching rays in the order of their sources, and lists the runs. */
static void pick_stored(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                        const struct rmap_matched *rays, const int32_t *of,
                        const double *const *column, double *const *to,
                        struct rmap_stats_block *block)
{
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY], n_quantity = setup->quantities->n;
    const uint8_t *match = rays->n_match < n_ray ? rays->match : NULL;
    size_t end = 0;
    if (setup->n_source == 2 && !match) {
        end = count_of(of, n_ray, 0);
        for (size_t q = 0; q < n_quantity; q++)
            (void)rmap_pick_both(column[q], of, 0, n_ray, to[q], to[q] + end);
        list_run(reader, setup, 0, end, block);
        list_run(reader, setup, 1, n_ray, block);
        return;
    }
    for (int32_t s = 0; s < (int32_t)setup->n_source; s++) {
        const size_t first = end;
        for (size_t q = 0; q < n_quantity; q++) {
            double *at = to[q] + first;
            end = first + (match ? rmap_pick_matching_of(column[q], match, of, s, n_ray, at)
                                 : rmap_pick_of(column[q], of, s, n_ray, at));
        }
        list_run(reader, setup, s, end, block);
    }
}

/* False: not all values are numbers. */
static bool measure(const struct rmap_stats_setup *setup, struct rmap_stats_block *block)
{
    block->is_measured = true;
    for (size_t q = 0; q < setup->quantities->n; q++) {
        block->measured[q] = rmap_stats_measure(block->value[q], block->n);
        block->is_measured = block->is_measured && isfinite(block->measured[q].sum);
    }
    return block->is_measured;
}

bool rmap_stats_read_stored(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                            const struct rmap_matched *rays, int32_t source, const int32_t *of,
                            const double *const *column, struct rmap_stats_block *block)
{
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY], n = rays->n_match;
    double *const *to = reader->into[0] ? reader->into : reader->arranged.value;
    reader->readings.n = n;
    reader->readings.n_undefined = 0;
    *block = (struct rmap_stats_block){.n = n, .run = reader->run};
    if (source < 0 && !of)
        pick_turns(reader, setup, n_ray, column, to, block);
    else if (source < 0)
        pick_stored(reader, setup, rays, of, column, to, block);
    else
        list_run(reader, setup, source, n, block);
    for (size_t q = 0; q < setup->quantities->n; q++) {
        if (source >= 0 && n < n_ray)
            (void)rmap_pick_matching(column[q], rays->match, n_ray, to[q]);
        block->value[q] = source >= 0 && n == n_ray ? column[q] : to[q];
    }
    return measure(setup, block);
}
