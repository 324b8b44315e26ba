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

#endif
