/* SPDX-License-Identifier: MIT
 *
 * What reading a map may take: with what a process takes without a map (some 80 MiB), the parts
 * below and in map_paths.h, query_known.c and ray_parts.c make up the 512 MiB that a query is
 * allowed per rank, however many threads it has.
 */
#ifndef RMAP_MAP_MEMORY_H
#define RMAP_MAP_MEMORY_H

#include "io/map/map_reader.h"

#define RMAP_CHUNKS_NBYTES ((size_t)128 << 20) /* inflated chunks of all cursors of a map */
#define RMAP_PORTIONS_NBYTES                                                                       \
    ((size_t)64 << 20) /* rows of the portions that threads have in hand                           \
                        */

/* Of so many bytes, the share of one of the map's cursors that have read chunks. */
size_t rmap_map_share(const struct rmap_map *map, size_t nbytes);

/* How many of n_thread threads may read: each has n_copy times these columns of a portion, and a
 * chunk of every one for one cursor that evaluates and one that reads. At least 1: a portion must
 * fit.
 */
int rmap_map_readers(const struct rmap_map *map, rmap_column_set columns, int n_copy, int n_thread);

#endif
