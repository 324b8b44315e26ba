/* SPDX-License-Identifier: MIT
 *
 * The files of a map in its directory: NAME.raymap/map.h5 and shard-RRRRR/piece-KKKKK.h5.
 */
#ifndef RMAP_MAP_DIRECTORY_H
#define RMAP_MAP_DIRECTORY_H

#include <stddef.h>

#include "base/status.h"

/* Smallest number that no piece in the directory has, and none above it. */
enum rmap_status rmap_shard_next_piece(const char *shard_path, int *number_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

struct rmap_piece_name {
    int shard, number;
};

/* All published pieces, by shard and number. *name_ret: rmap_free. */
enum rmap_status rmap_map_list_pieces(const char *map_path, struct rmap_piece_name **name_ret,
                                      size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
