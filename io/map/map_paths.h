/* SPDX-License-Identifier: MIT
 *
 * What decoding a compact piece takes beside its portions' rows: the model of its colour space's
 * scene, and the paths that its rays refer to. Made when first needed, kept with the map.
 */
#ifndef RMAP_MAP_PATHS_H
#define RMAP_MAP_PATHS_H

#include "compact/compact.h"
#include "compact/path_sum.h"
#include "io/map/chunk_reader.h"

/* Borrowed from the map; thread-safe. traces: rays are traced with it, not their paths looked at
 * alone. RMAP_SYSTEM. */
enum rmap_status rmap_map_model(const struct rmap_map *map, size_t space, bool traces,
                                const struct rmap_compact_model **model_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Borrowed until it is given back (NULL is fine); thread-safe. Not `whole`: heads of paths, which
 * are enough for columns of rays, may be all. RMAP_FORMAT names the piece. Those that nobody has
 * are let go, the one that was asked for longest ago first, when all take more than
 * RMAP_PATHS_NBYTES. */
#define RMAP_PATHS_NBYTES ((size_t)96 << 20)
enum rmap_status rmap_map_paths(const struct rmap_map *map, size_t piece, bool whole,
                                struct rmap_chunk_reader *reader,
                                const struct rmap_path_table **paths_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Of paths that the caller has, and as long: what the piece says that its rays with each of them
 * have in common, lengths only if they are asked for. *sum_ret: [paths], NULL where it does not
 * say, or what it says is damaged. */
enum rmap_status rmap_map_path_sums(const struct rmap_map *map, size_t piece, bool lengths,
                                    const struct rmap_path_sum **sum_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Of paths that the caller has: whether all values of them, as of columns, name something of the
 * map's scene. */
bool rmap_map_paths_fit(const struct rmap_map *map, size_t piece);

/* Of paths that the caller has, so: their stored bytes. No reader counts them as bytes of rows: who
 * reads a piece's paths, and how often, depends on ranks, threads and memory. */
uint64_t rmap_map_paths_stored_nbytes(const struct rmap_map *map, size_t piece, bool whole);

void rmap_map_paths_give_back(const struct rmap_map *map, size_t piece,
                              const struct rmap_path_table *paths);

#endif
