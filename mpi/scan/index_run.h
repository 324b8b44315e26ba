/* SPDX-License-Identifier: MIT
 *
 * Making the history indexes of a map: each piece on whichever thread of whichever rank is free.
 */
#ifndef RMAP_INDEX_RUN_H
#define RMAP_INDEX_RUN_H

#include "io/map/map_reader.h"
#include "mpi/command/command.h"

/* Of these: */
enum {
    RMAP_INDEX_REMAKE = 1, /* also those that are there and good */
    RMAP_INDEX_LARGE = 2   /* also those that take more than a tenth of the map */
};

struct rmap_index_result {
    uint64_t n_piece, n_made;       /* sealed pieces; those that had no index and have one now */
    uint64_t n_large, large_nbytes; /* those left without, and about what theirs would have taken */
    uint64_t nbytes;                /* of all their indexes */
    uint64_t map_nbytes;            /* without them */
    double seconds;
};

/* Collective. flags: see above. Without RMAP_INDEX_LARGE all indexes take a tenth of the map at
 * most, and 64 KiB, in which small maps have theirs; a piece has its share of both. The result is
 * for every rank. RMAP_INPUT, RMAP_FORMAT, RMAP_SYSTEM; what was made until then stays. */
enum rmap_status rmap_index_run(const struct rmap_context *context, const char *path, int flags,
                                struct rmap_index_result *result,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Bytes that the index of a piece may take on disk without RMAP_INDEX_LARGE, for each byte of the
 * piece. */
double rmap_index_allowed(const struct rmap_map *map);

/* What was left without an index and why, in one line; empty: nothing. */
void rmap_index_tell_large(const struct rmap_index_result *result, char *line, size_t cap);

#endif
