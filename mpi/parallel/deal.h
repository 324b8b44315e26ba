/* SPDX-License-Identifier: MIT
 *
 * Which rank works on which portions of a map, known to every rank.
 */
#ifndef RMAP_DEAL_H
#define RMAP_DEAL_H

#include "base/status.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/context.h"

/* A chunk of /ray is 16 traced portions: so many are decoded together. */
#define RMAP_DEAL_STEP_MAX 16

enum rmap_deal_kind {
    RMAP_DEAL_TURNS,  /* runs of portions in turn: all ranks work near the same place */
    RMAP_DEAL_SHARES, /* one run each, of about as many rows */
    RMAP_DEAL_LOCAL   /* by shard: shard s belongs to rank s modulo the ranks */
};

struct rmap_deal {
    size_t step;     /* portions of a part */
    size_t *portion; /* [portions of the map], rank after rank, ascending within each */
    size_t *first;   /* [ranks + 1]: rank r has those from first[r] on */
};

enum rmap_status rmap_deal_init(const struct rmap_map *map, enum rmap_deal_kind kind, int size,
                                struct rmap_deal *deal, struct rmap_error *err) RMAP_MUST_USE;
void rmap_deal_fini(struct rmap_deal *deal); /* zeroed: fine */

size_t rmap_deal_n_part(const struct rmap_deal *deal, int rank);

/* Portions [*n_ret] of a rank's part, ascending. */
const size_t *rmap_deal_part(const struct rmap_deal *deal, int rank, size_t part, size_t *n_ret);

#endif
