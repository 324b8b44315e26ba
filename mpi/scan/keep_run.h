/* SPDX-License-Identifier: MIT
 *
 * Writing columns of a map's compact pieces beside them: pieces dealt to ranks, the portions of one
 * to the rank's threads.
 */
#ifndef RMAP_KEEP_RUN_H
#define RMAP_KEEP_RUN_H

#include "io/map/map_reader.h"
#include "mpi/command/command.h"

struct rmap_keep_result {
    uint64_t n_piece, n_made; /* sealed compact pieces; those that were written to now */
    double seconds;
};

/* Collective. Pieces that have these columns are passed over, unless force is set; what they have
 * besides stays. The result is for every rank. The map knows nothing of what was made until it is
 * opened again. */
enum rmap_status rmap_keep_run(const struct rmap_context *context, const struct rmap_map *map,
                               rmap_column_set columns, bool force, struct rmap_keep_result *result,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
