/* SPDX-License-Identifier: MIT
 *
 * What of an open map stays in memory from one question to the next.
 */
#include "io/map/map_history.h"
#include "io/map/map_internal.h"

/* Indexes that the map was given count from the start, as many of their bytes as may. */
static void claim_given(struct rmap_map *map, size_t budget_nbytes)
{
    const size_t given = rmap_map_history_kept_nbytes(map);
    (void)rmap_keeper_claim(map->keeper, given < budget_nbytes ? given : budget_nbytes);
}

enum rmap_status rmap_map_keep(struct rmap_map *map, size_t budget_nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_portion = map->content.n_portion;
    if (map->keeper)
        return rmap_error_set(err, RMAP_USAGE, "%s: columns are kept already", map->path);
    RMAP_TRY(rmap_keeper_create(budget_nbytes, &map->keeper, err));
    claim_given(map, budget_nbytes);
    RMAP_TRY(rmap_kept_views_create(n_portion, map->keeper, &map->views, err));
    RMAP_TRY(rmap_column_store_create(n_portion, map->keeper, &map->store, err));
out:
    return st;
}

rmap_column_set rmap_map_borrow_columns(const struct rmap_map *map, size_t portion,
                                        rmap_column_set columns, struct rmap_portion *rows)
{
    rmap_column_set found = 0;
    for (int c = 0; map->store && c < RMAP_COLUMN_COUNT; c++) {
        void *kept = columns & RMAP_COLUMN_BIT(c)
                         ? rmap_column_store_get(map->store, portion, (enum rmap_column)c)
                         : NULL;
        if (!kept)
            continue;
        *rmap_portion_column_address(rows, (enum rmap_column)c) = kept;
        found |= RMAP_COLUMN_BIT(c);
    }
    return found;
}

void rmap_map_keep_columns(const struct rmap_map *map, size_t portion, rmap_column_set columns,
                           const struct rmap_portion *rows)
{
    for (int c = 0; map->store && c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            rmap_column_store_offer(map->store, portion, (enum rmap_column)c,
                                    rmap_portion_column(rows, (enum rmap_column)c),
                                    rows->n_row[rmap_column_info((enum rmap_column)c)->table] *
                                        rmap_portion_row_nbytes(rows, (enum rmap_column)c));
}

enum rmap_status rmap_history_reader_enter(const struct rmap_map *map,
                                           const struct rmap_history_index *index, size_t at,
                                           size_t portion, struct rmap_history_reader *self,
                                           struct rmap_error *err)
{
    rmap_history_reader_leave(map, self);
    self->portion = portion;
    self->lent = map->views ? rmap_kept_views_lend(map->views, portion) : NULL;
    enum rmap_status st = self->lent
                              ? rmap_history_view_reopen(index, at, self->lent, &self->view, err)
                              : rmap_history_view_open(index, at, &self->view, err);
    self->is_open = st == RMAP_OK;
    if (self->is_open && !self->lent)
        self->nbytes += self->view.nbytes;
    if (!self->is_open)
        rmap_history_reader_leave(map, self);
    return st;
}

void rmap_history_reader_leave(const struct rmap_map *map, struct rmap_history_reader *self)
{
    if (self->lent)
        rmap_kept_views_give_back(map->views, self->portion, self->lent);
    else if (self->is_open && map->views &&
             rmap_map_history_stays(map, (size_t)map->content.portion[self->portion].piece))
        rmap_kept_views_offer(map->views, self->portion, &self->view);
    self->lent = NULL;
    self->is_open = false;
}

void rmap_history_reader_fini(const struct rmap_map *map, struct rmap_history_reader *self)
{
    rmap_history_reader_leave(map, self);
    rmap_history_view_fini(&self->view);
}

void rmap_map_kept(const struct rmap_map *map, struct rmap_map_kept *kept)
{
    *kept = (struct rmap_map_kept){.indexes = rmap_map_history_kept_nbytes(map)};
    if (!map->keeper)
        return;
    kept->budget = rmap_keeper_limit(map->keeper);
    kept->taken = rmap_keeper_nbytes(map->keeper);
    kept->views = map->views ? rmap_kept_views_nbytes(map->views) : 0;
    kept->columns = map->store ? rmap_column_store_nbytes(map->store) : 0;
}
