/* SPDX-License-Identifier: MIT
 *
 * Where the chunks of a piece lie. The table comes from a file, so nothing in it is believed: each
 * stream must have exactly the chunks that its rows need, inside the piece's file.
 */
#ifndef RMAP_MAP_CHUNKS_H
#define RMAP_MAP_CHUNKS_H

#include "io/map/map_reader.h"

/* That every finished piece is there with the size that the index states; opens none of them. */
enum rmap_status rmap_map_check_pieces(const struct rmap_map *map,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* "MAP/shard-00000/piece-00000.h5"; rmap_free. NULL when memory is short. */
char *rmap_map_piece_path(const struct rmap_map *map, size_t piece);

const struct rmap_layout *rmap_map_piece_layout(const struct rmap_map *map, size_t piece);

int rmap_map_piece_n_channel(const struct rmap_map *map, size_t piece);

struct rmap_piece_chunks;

/* Chunks of a piece, checked the first time against its rows and its file: borrowed from the map.
 * Thread-safe. RMAP_FORMAT when the piece is missing, of another size, or inconsistent. */
enum rmap_status rmap_map_piece_chunks(const struct rmap_map *map, size_t piece,
                                       const struct rmap_piece_chunks **chunks_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
