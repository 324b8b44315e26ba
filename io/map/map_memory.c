/* SPDX-License-Identifier: MIT
 *
 * What reading a map may take: with what a process takes without a map (some 80 MiB), the parts
 * below and in map_paths.h, query_known.c and ray_parts.c make up the 512 MiB
 * that a query is allowed per rank, however many threads it has.
 */
#include "io/map/map_memory.h"

#include "io/map/map_internal.h"

enum { CURSORS = 2 };

/* Of columns, in a portion of so many rows of each table. */
static size_t columns_nbytes(const struct rmap_map *map, rmap_column_set columns,
                             const uint64_t *n_row)
{
    const struct rmap_portion shape = {.n_channel = map->n_channel_max};
    size_t nbytes = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            nbytes += rmap_portion_row_nbytes(&shape, (enum rmap_column)c) *
                      (size_t)n_row[rmap_column_info((enum rmap_column)c)->table];
    return nbytes;
}

size_t rmap_map_share(const struct rmap_map *map, size_t nbytes)
{
    int n = atomic_load(&map->n_reader);
    return n > 1 ? nbytes / (size_t)n : nbytes;
}

int rmap_map_readers(const struct rmap_map *map, rmap_column_set columns, int n_copy, int n_thread)
{
    uint64_t chunk[RMAP_TABLE_COUNT];
    size_t most = 1;
    columns &= rmap_columns_of_run(map->scene[0]->timed);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        chunk[t] = RMAP_CHUNK_ROWS;
    for (size_t i = 0; i < map->content.n_portion; i++) {
        size_t nbytes =
            columns_nbytes(map, columns, map->content.portion[i].n_row) * (size_t)n_copy;
        most = nbytes > most ? nbytes : most;
    }
    size_t n = RMAP_PORTIONS_NBYTES / most;
    size_t by_chunks = RMAP_CHUNKS_NBYTES / (CURSORS * columns_nbytes(map, columns, chunk) + 1);
    n = by_chunks < n ? by_chunks : n;
    return n < 1 ? 1 : n < (size_t)n_thread ? (int)n : n_thread;
}
