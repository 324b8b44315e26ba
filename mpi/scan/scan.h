/* SPDX-License-Identifier: MIT
 *
 * One scan of a whole map, its portions scattered over ranks and threads.
 */
#ifndef RMAP_SCAN_H
#define RMAP_SCAN_H

#include "analysis/query/query.h"
#include "analysis/query/query_mark.h"
#include "mpi/command/command.h"
#include "mpi/parallel/deal.h"

/* Part `part` of n_part of the portions [first, last): contiguous, balanced by rows. How they are
 * cut changes no answer. */
void rmap_scan_range(const struct rmap_map *map, size_t first, size_t last, int part, int n_part,
                     size_t *first_ret, size_t *last_ret);

/* Collective. count: [n_criterion], initialised by the caller; added to, the same on every rank.
 * How the portions are dealt changes no answer. */
enum rmap_status rmap_scan_map(const struct rmap_context *context, const struct rmap_map *map,
                               struct rmap_criterion *const *criterion, size_t n_criterion,
                               enum rmap_deal_kind deal, struct rmap_count *count,
                               struct rmap_error *err) RMAP_MUST_USE;

/* Collective. *rays_ret: on rank 0 (NULL on the others) a portion with the first `limit` rays that
 * are picked, in the order of their ids, with the channels of the map's widest colour space, those
 * that a ray's own space lacks being 0; rmap_portion_destroy. */
enum rmap_status rmap_scan_collect(const struct rmap_context *context, const struct rmap_map *map,
                                   const struct rmap_pick *pick, uint64_t limit,
                                   struct rmap_portion **rays_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
