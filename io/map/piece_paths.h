/* SPDX-License-Identifier: MIT
 *
 * The rays of a whole piece by the paths of its dictionary: what takes no portion to be read.
 */
#ifndef RMAP_PIECE_PATHS_H
#define RMAP_PIECE_PATHS_H

#include "compact/path_sum.h"
#include "io/map/map_reader.h"

/* What the portions that a map lists of a piece hold. */
struct rmap_piece_sum {
    uint64_t n_row[RMAP_TABLE_COUNT];
    uint64_t n_own, n_own_registration; /* rows of rays with paths of their own */
};

/* *sum_ret: [n_piece]; rmap_free. RMAP_SYSTEM. */
enum rmap_status rmap_piece_sums(const struct rmap_map *map, struct rmap_piece_sum **sum_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

struct rmap_piece_paths {
    const struct rmap_portion *paths; /* as rays, columns RMAP_COLUMNS_DISCRETE; borrowed */
    const struct rmap_path_sum *of; /* [its rays] without lengths: rays of the piece that have this
                                       path, each of weight 1; all others have paths of their own;
                                       borrowed */
    struct rmap_chunk_reader *reader;
    const struct rmap_path_table *table;
    const struct rmap_map *map;
    size_t piece;
};

/* whole: as for rmap_map_paths; else `paths` need not have rows but of /ray. *told_ret: false where
 * the piece does not say, or says it of other portions than the map lists. Errors name the piece.
 * Else fini whatever was told. */
enum rmap_status rmap_piece_paths_open(const struct rmap_map *map, size_t piece, bool whole,
                                       const struct rmap_piece_sum *sum,
                                       struct rmap_piece_paths *self, bool *told_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_piece_paths_fini(struct rmap_piece_paths *self); /* zeroed: fine */

#endif
