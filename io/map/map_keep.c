/* SPDX-License-Identifier: MIT
 *
 * What of an open map stays in memory from one question to the next: decoded columns, and what
 * compact pieces store of paths.
 */
#include "io/map/map_keep.h"

#include "compact/streams.h"
#include "io/map/map_internal.h"

enum rmap_status rmap_map_keep(struct rmap_map *map, size_t budget_nbytes, struct rmap_error *err)
{
    if (map->store)
        return rmap_error_set(err, RMAP_USAGE, "%s: columns are kept already", map->path);
    return rmap_column_store_create(map->content.n_portion, budget_nbytes, &map->store, err);
}

void rmap_map_kept(const struct rmap_map *map, struct rmap_map_kept *kept)
{
    *kept = (struct rmap_map_kept){0};
    if (!map->store)
        return;
    kept->budget = rmap_column_store_budget(map->store);
    kept->taken = rmap_column_store_taken(map->store);
    kept->columns = rmap_column_store_nbytes(map->store, false);
    kept->paths = rmap_column_store_nbytes(map->store, true);
}

rmap_column_set rmap_map_borrow_columns(const struct rmap_map *map, size_t portion,
                                        rmap_column_set columns, struct rmap_portion *rows)
{
    rmap_column_set found = 0;
    for (int c = 0; map->store && c < RMAP_COLUMN_COUNT; c++) {
        void *kept =
            columns & RMAP_COLUMN_BIT(c) ? rmap_column_store_get(map->store, portion, c) : NULL;
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
            rmap_column_store_offer(map->store, portion, c,
                                    rmap_portion_column(rows, (enum rmap_column)c),
                                    rows->n_row[rmap_column_info((enum rmap_column)c)->table] *
                                        rmap_portion_row_nbytes(rows, (enum rmap_column)c));
}

static bool tells_paths(int stream)
{
    return stream == RMAP_STREAM_ray_path || stream == RMAP_STREAM_pool64 ||
           (stream >= RMAP_STREAM_OWN_source && stream <= RMAP_STREAM_OWN_registered);
}

void *rmap_map_borrow_stream(const struct rmap_map *map, size_t portion, int stream)
{
    return map->store && tells_paths(stream)
               ? rmap_column_store_get(map->store, portion, RMAP_STORE_STREAM + stream)
               : NULL;
}

void rmap_map_keep_stream(const struct rmap_map *map, size_t portion, int stream, const void *rows,
                          size_t nbytes)
{
    if (map->store && tells_paths(stream))
        rmap_column_store_offer(map->store, portion, RMAP_STORE_STREAM + stream, rows, nbytes);
}
