/* SPDX-License-Identifier: MIT
 *
 * Getting a map ready for many questions: history indexes in memory for pieces that have none on
 * disk.
 */
#ifndef RMAP_SESSION_WARM_H
#define RMAP_SESSION_WARM_H

#include "io/map/map_reader.h"
#include "mpi/command/command.h"

struct rmap_warmth {
    uint64_t n_piece; /* whose index was made */
    uint64_t n_large; /* of those: that `raymap index` makes on disk with --large only */
    uint64_t nbytes;
};

/* Collective. Each rank makes the indexes of the pieces that its share of a scan reads, until they
 * take budget_nbytes. *warmth: of all ranks. */
enum rmap_status rmap_session_warm(const struct rmap_context *context, const struct rmap_map *map,
                                   uint64_t budget_nbytes, struct rmap_warmth *warmth,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
