/* SPDX-License-Identifier: MIT
 *
 * The ids of N of the rays that a question picks: the first ones, or a sample.
 */
#ifndef RMAP_RAY_SAMPLE_H
#define RMAP_RAY_SAMPLE_H

#include "analysis/query/query_mark.h"
#include "analysis/query/sample_fold.h"
#include "mpi/command/command.h"
#include "mpi/parallel/deal.h"

/* Collective. *id_ret: ascending [*n_ret], the same on every rank; rmap_free. Takes memory for the
 * ids alone. Without hashes reading stops soon after the last of them. */
enum rmap_status rmap_ray_sample(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_pick *pick, enum rmap_deal_kind deal,
                                 const struct rmap_sample_order *order, uint64_t **id_ret,
                                 size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
