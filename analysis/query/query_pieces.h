/* SPDX-License-Identifier: MIT
 *
 * Discrete criteria on whole pieces: a compact piece knows how many rays have each path of its
 * dictionary, so that only rays with paths of their own are left to be looked at.
 */
#ifndef RMAP_QUERY_PIECES_H
#define RMAP_QUERY_PIECES_H

#include "analysis/query/query.h"

/* Adds the rays of pieces first, first + step, ... whose paths are in the dictionaries to the
 * counts: count [n_criterion]. *counted_ret: [n_criterion][n_piece], 1 for those that were, or
 * NULL, on every rank that has the map, where no criterion can be counted so; rmap_free. One
 * thread. Errors as of reading paths. */
enum rmap_status rmap_query_pieces_count(const struct rmap_map *map,
                                         struct rmap_criterion *const *criterion,
                                         size_t n_criterion, size_t first, size_t step,
                                         struct rmap_count *count, uint8_t **counted_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
