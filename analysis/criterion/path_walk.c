/* SPDX-License-Identifier: MIT
 *
 * A path("...") put to the history up to a registration, from one registration of a ray to its
 * next.
 */
#include "analysis/criterion/path_walk.h"

struct rmap_path_walk rmap_path_walk_from(const struct rmap_path_table *table, size_t ray,
                                          size_t first_step, size_t first_hit)
{
    return (struct rmap_path_walk){.table = table,
                                   .ray = ray,
                                   .first_step = first_step,
                                   .next_hit = first_hit,
                                   .last_symbol = 2 * table->n_symbol};
}

static void take(struct rmap_path_walk *walk, uint32_t symbol)
{
    if (walk->last_symbol < walk->table->n_symbol)
        walk->state = walk->table->next[walk->state + walk->last_symbol];
    walk->last_symbol = symbol;
}

bool rmap_path_walk_to(struct rmap_path_walk *walk, const struct rmap_portion *portion, size_t hit)
{
    const struct rmap_path_table *table = walk->table;
    const struct rmap_registration_columns *from = &portion->registration;
    const uint32_t n_step = portion->ray.segment_count[walk->ray];
    for (; walk->next_hit <= hit; walk->next_hit++) {
        const size_t row = walk->next_hit, place = rmap_path_place(table, from, row);
        for (; walk->n_step < place && walk->n_step < n_step; walk->n_step++)
            take(walk,
                 rmap_path_row_symbol(table, &portion->segment, walk->first_step + walk->n_step));
        if (from->registered[row])
            take(walk, rmap_path_hit_symbol(table, from->detector[row]));
    }
    const uint32_t n_symbol = table->n_symbol, last = walk->last_symbol;
    return table->next[walk->state + (last < n_symbol ? last + n_symbol : last)] == table->width;
}
