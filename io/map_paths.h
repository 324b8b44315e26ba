/* SPDX-License-Identifier: MIT
 *
 * What decoding a compact piece takes beside its portions' rows: the model of its colour space's
 * scene, and the paths that its rays refer to. Made when first needed, kept with the map.
 */
#ifndef RMAP_MAP_PATHS_H
#define RMAP_MAP_PATHS_H

#include "compact/compact.h"
#include "io/chunk_reader.h"

/* Both borrowed from the map; thread-safe. RMAP_FORMAT names the piece. */
enum rmap_status rmap_map_model(const struct rmap_map *map, size_t space,
                                const struct rmap_compact_model **model_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_map_paths(const struct rmap_map *map, size_t piece,
                                struct rmap_chunk_reader *reader,
                                const struct rmap_path_table **paths_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
