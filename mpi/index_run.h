/* SPDX-License-Identifier: MIT
 *
 * Making the history indexes of a map: each piece on whichever thread of whichever rank is free.
 */
#ifndef RMAP_INDEX_RUN_H
#define RMAP_INDEX_RUN_H

#include "mpi/command.h"

struct rmap_index_result {
    uint64_t n_piece, n_made; /* sealed pieces; those that had no index */
    uint64_t nbytes;          /* of all their indexes */
    uint64_t map_nbytes;      /* without them */
    double seconds;
};

/* Collective. remake: also those that are there and good. The result is for every rank. RMAP_INPUT,
 * RMAP_FORMAT, RMAP_SYSTEM; what was made until then stays. */
enum rmap_status rmap_index_run(const struct rmap_context *context, const char *path, bool remake,
                                struct rmap_index_result *result,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
