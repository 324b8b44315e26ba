/* SPDX-License-Identifier: MIT
 *
 * Portions of an open map written again into shards, on all ranks and threads: what `convert` does
 * with a whole map and `repair` with what is left of a damaged piece.
 */
#ifndef RMAP_COPY_RUN_H
#define RMAP_COPY_RUN_H

#include "io/map_reader.h"
#include "io/map_writer.h"
#include "mpi/command.h"

struct rmap_copy_plan {
    const struct rmap_map *map;
    const size_t *portion; /* of the map, ascending [n_portion]; the same on every rank */
    size_t n_portion;
    struct rmap_shard_writer *writer; /* this rank's */
    const char *what;                 /* for the progress line, "rays" */
};

/* Collective. Every rank decodes a contiguous share of the portions, its threads in turn, and
 * appends them to its writer; then the writer is finished. RMAP_FORMAT names what cannot be read.
 * Rows come out as they went in; one rank with one thread keeps their order too. */
enum rmap_status rmap_copy_run(const struct rmap_context *context,
                               const struct rmap_copy_plan *plan,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
