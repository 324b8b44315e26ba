/* SPDX-License-Identifier: MIT
 *
 * The rays of a picture that several criteria share.
 */
#ifndef RMAP_DRAW_PICK_H
#define RMAP_DRAW_PICK_H

#include "analysis/query/query.h"
#include "mpi/command/command.h"

/* All borrowed; the criteria are compiled against the scene with the overlay's receivers. */
struct rmap_draw_question {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;            /* NULL: none */
    const struct rmap_criterion *any;              /* the rays that match any of: */
    const struct rmap_criterion *const *criterion; /* [n_criterion] */
    const struct rmap_count *matching;             /* [n_criterion] on rank 0: what each matches */
    size_t n_criterion;
    uint64_t most; /* rays, of all criteria together */
};

/* Collective. Of each criterion the matching rays with the smallest ids: all of a rare one, and
 * what those leave in equal shares; `most` in all, if so many match any. *id_ret: ascending
 * [*n_ret], the same on every rank; rmap_free. */
enum rmap_status rmap_draw_pick(const struct rmap_context *context,
                                const struct rmap_draw_question *question, uint64_t **id_ret,
                                size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
