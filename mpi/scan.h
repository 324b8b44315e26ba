/* SPDX-License-Identifier: MIT
 *
 * One scan of a whole map, its portions scattered over ranks and threads.
 */
#ifndef RMAP_SCAN_H
#define RMAP_SCAN_H

#include "analysis/query.h"
#include "mpi/command.h"

/* Portions of this rank and, of those, of one of its threads: contiguous, balanced by rows. The
 * cut does not change any answer. */
void rmap_scan_range(const struct rmap_map *map, int part, int n_part, size_t *first_ret,
                     size_t *last_ret);

/* Collective. count: [n_criterion], the same on every rank at the end.
 * collect_ret: NULL, or on rank 0 a portion (caller destroys; NULL on the other ranks) with the
 * rays that match criterion 0, at most `limit` of them, those with the smallest ids, in order. */
enum rmap_status rmap_scan_map(const struct rmap_context *context, const struct rmap_map *map,
                               struct rmap_criterion *const *criterion, size_t n_criterion,
                               struct rmap_count *count, struct rmap_portion **collect_ret,
                               uint64_t limit, struct rmap_error *err) RMAP_MUST_USE;

#endif
