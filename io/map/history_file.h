/* SPDX-License-Identifier: MIT
 *
 * History indexes, shard-RRRRR/piece-KKKKK.history.h5: earlier versions wrote them beside pieces,
 * and nobody reads them any more.
 */
#ifndef RMAP_HISTORY_FILE_H
#define RMAP_HISTORY_FILE_H

#include "io/map/map_directory.h"
#include "io/map/map_reader.h"

struct rmap_history_files {
    size_t n;
    uint64_t nbytes;
};
enum rmap_status rmap_history_files_measure(const struct rmap_map *map,
                                            struct rmap_history_files *files,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* "MAP/shard-00000/piece-00000.history.h5"; rmap_free. NULL when memory is short. */
char *rmap_history_path(const char *map_path, const struct rmap_piece_name *piece);

#endif
