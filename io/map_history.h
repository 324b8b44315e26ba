/* SPDX-License-Identifier: MIT
 *
 * The history indexes of an open map: piece-KKKKK.history.h5 beside piece-KKKKK.h5, where it was
 * made (`raymap index`). Opened when first needed, let go again when many are.
 */
#ifndef RMAP_MAP_HISTORY_H
#define RMAP_MAP_HISTORY_H

#include "history/history_index.h"
#include "io/map_reader.h"

/* The index of a piece, to be given back by rmap_map_history_release with the piece's number; NULL,
 * with nothing to give back: it has none, or one that is damaged or belongs to other rays, so that
 * columns are to be read (verify tells why). Thread-safe. RMAP_SYSTEM alone. */
enum rmap_status rmap_map_history(const struct rmap_map *map, size_t piece,
                                  const struct rmap_history_index **index_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_history_release(const struct rmap_map *map, size_t piece);

#endif
