/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_stored.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/pick.h"
#include "base/wide.h"

RMAP_WIDE static size_t count_of(const int32_t *source, size_t n, int32_t which)
{
    uint32_t count = 0;
    for (size_t i = 0; i < n; i++)
        count += source[i] == which;
    return count;
}

static void list_run(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                     int32_t source, size_t end, struct rmap_stats_block *block)
{
    const size_t first = block->n_run > 0 ? reader->run[block->n_run - 1].end : 0;
    if (end > first)
        reader->run[block->n_run++] =
            (struct rmap_stats_run){end, rmap_stats_class_of(setup, source)};
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
    if (source < 0)
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
