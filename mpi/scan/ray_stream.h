/* SPDX-License-Identifier: MIT
 *
 * Rays of a map that a question picks, found by all ranks and handed to rank 0 one by one in the
 * order of their ids. Memory is bounded, whatever the map and the answer: parts of some portions
 * are worked on ahead of what rank 0 takes, and no further.
 */
#ifndef RMAP_RAY_STREAM_H
#define RMAP_RAY_STREAM_H

#include "analysis/query/query_mark.h"
#include "mpi/command/command.h"
#include "mpi/parallel/deal.h"

/* A ray as it is handed over: row `row` of a portion that has the pick's columns, its rows of the
 * other tables from `segment` and `registration` on. Borrowed for the call. */
struct rmap_streamed_ray {
    const struct rmap_portion *portion;
    size_t row, segment, registration;
    size_t space; /* colour space: the portion has its channels */
};

struct rmap_ray_sink {
    void *context;
    enum rmap_status (*take)(void *context, const struct rmap_streamed_ray *ray,
                             struct rmap_error *err);
};

/* Collective. The sink is rank 0's. At most `limit` rays, those with the smallest ids; reading
 * stops soon after the last of them. The same rays in the same order for any number of ranks and
 * threads. *n_ret: how many, on rank 0. */
enum rmap_status rmap_ray_stream(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_pick *pick, enum rmap_deal_kind deal,
                                 uint64_t limit, const struct rmap_ray_sink *sink, uint64_t *n_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
