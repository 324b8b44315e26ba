/* SPDX-License-Identifier: MIT
 *
 * Rays that match a criterion about receivers (--receivers): counted, and by their ids, so that
 * whatever reads rays of a map by their ids goes on from there.
 */
#ifndef RMAP_OVERLAY_PICK_H
#define RMAP_OVERLAY_PICK_H

#include "analysis/query/query.h"
#include "analysis/query/sample_fold.h"
#include "mpi/command/command.h"

/* All borrowed; the criterion is compiled against the overlay's scene. */
struct rmap_overlay_question {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;
    const struct rmap_criterion *criterion; /* NULL: all rays */
};

/* Collective. Adds to the count of rank 0. */
enum rmap_status rmap_overlay_count_run(const struct rmap_context *context,
                                        const struct rmap_overlay_question *question,
                                        struct rmap_count *count,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Ids that are kept of all matching rays: 128 MiB of each thread. */
#define RMAP_OVERLAY_PICK_MOST ((uint64_t)1 << 23)

/* Collective. *id_ret: ascending [*n_ret], the same on every rank; rmap_free. order->most
 * UINT64_MAX: all, RMAP_SYSTEM when they are more than RMAP_OVERLAY_PICK_MOST. */
enum rmap_status rmap_overlay_pick(const struct rmap_context *context,
                                   const struct rmap_overlay_question *question,
                                   const struct rmap_sample_order *order, uint64_t **id_ret,
                                   size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
