/* SPDX-License-Identifier: MIT
 *
 * What a line of a session asks, answered.
 */
#ifndef RMAP_SESSION_ANSWER_H
#define RMAP_SESSION_ANSWER_H

#include "analysis/criterion/criterion_file.h"
#include "io/map/map_reader.h"
#include "mpi/command/command.h"
#include "mpi/session/session_memo.h"

struct rmap_session {
    const struct rmap_context *context; /* json: one document per answer, on a line of its own */
    const char *path;                   /* of the map */
    struct rmap_map *map;
    struct rmap_criteria *criteria; /* names defined so far; NULL: none */
    uint64_t memory;                /* bytes per rank for what is kept */
    struct rmap_session_memo memo;
    bool warm; /* what can be prepared has been */
    bool quit;
};

/* Collective: the same line on every rank. Rank 0 prints the answer. RMAP_INPUT: the line is wrong,
 * the session goes on; anything else but RMAP_OK ends it. */
enum rmap_status rmap_session_answer(struct rmap_session *session, const char *line,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
