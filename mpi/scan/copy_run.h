/* SPDX-License-Identifier: MIT
 *
 * Portions of an open map written again into shards, on all ranks and threads: what `convert` does
 * with a whole map and `repair` with what is left of a damaged piece.
 */
#ifndef RMAP_COPY_RUN_H
#define RMAP_COPY_RUN_H

#include "io/map/map_content.h"
#include "io/map/map_writer.h"
#include "mpi/command/command.h"

struct rmap_copy_plan {
    const struct rmap_map *map;
    const uint8_t *skip;         /* [portions of the map] 1: is left out; NULL: all are written */
    const char *to;              /* directory of the map to write into, which exists */
    int shard;                   /* of rank 0; the other ranks' follow */
    enum rmap_encoding encoding; /* RMAP_ENCODING_COUNT: of each portion's own piece */
    size_t piece_nbytes;         /* 0: as a trace */
};

/* Collective. Every rank decodes a contiguous share of the portions, its threads in turn, and
 * appends them to its shard. On rank 0 the pieces of all ranks are appended to *content, for the
 * index. RMAP_FORMAT names what cannot be read. Rows come out as they went in; one rank with one
 * thread keeps their order too. */
enum rmap_status rmap_copy_run(const struct rmap_context *context,
                               const struct rmap_copy_plan *plan, struct rmap_map_content *content,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
