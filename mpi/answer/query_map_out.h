/* SPDX-License-Identifier: MIT
 *
 * The answer to a query as a ray map of its own.
 */
#ifndef RMAP_QUERY_MAP_OUT_H
#define RMAP_QUERY_MAP_OUT_H

#include "mpi/command/command.h"
#include "mpi/scan/pick_run.h"

struct rmap_map_answer {
    const struct rmap_map *map;
    const struct rmap_pick *pick;
    enum rmap_deal_kind deal;
    enum rmap_encoding encoding; /* RMAP_ENCODING_COUNT: that of the map's first piece */
    const char *from, *to;       /* directories */
    const char *criterion;       /* as it was written, */
    const char *spelled;         /* and without names, for the map */
    const char *answer;          /* "all", "limit 10", "sample 100 seed 1" */
    bool force;
};

/* True for a name that -o takes for a map: NAME.raymap, or a directory that no file is named like.
 */
bool rmap_map_answer_is(const char *path);

/* Collective. RMAP_USAGE when something stands there, or it is the map that is asked. */
enum rmap_status rmap_map_answer_write(const struct rmap_context *context,
                                       const struct rmap_map_answer *answer,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
