/* SPDX-License-Identifier: MIT
 *
 * One scan of a whole map, its portions scattered over ranks and threads.
 */
#ifndef RMAP_SCAN_H
#define RMAP_SCAN_H

#include "analysis/query.h"
#include "mpi/command.h"

/* Part `part` of n_part of the portions [first, last): contiguous, balanced by rows. How they are
 * cut changes no answer. */
void rmap_scan_range(const struct rmap_map *map, size_t first, size_t last, int part, int n_part,
                     size_t *first_ret, size_t *last_ret);

/* Collective. count: [n_criterion], initialised by the caller; added to, the same on every rank.
 * collect_ret: NULL, or on rank 0 a portion (caller destroys; NULL on the other ranks) with the
 * rays that match criterion 0, in the order of their ids: all of them, or with a limit below
 * UINT64_MAX the first so many, and then reading stops soon and counts are of what was read. */
enum rmap_status rmap_scan_map(const struct rmap_context *context, const struct rmap_map *map,
                               struct rmap_criterion *const *criterion, size_t n_criterion,
                               struct rmap_count *count, struct rmap_portion **collect_ret,
                               uint64_t limit, struct rmap_error *err) RMAP_MUST_USE;

#endif
