/* SPDX-License-Identifier: MIT
 *
 * A run of `raymap trace` from the loaded scene to the finished index: what the map lacks is
 * found, traced request by request, and told.
 */
#ifndef RMAP_TRACE_SESSION_H
#define RMAP_TRACE_SESSION_H

#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "io/map/map_lock.h"
#include "mpi/trace/trace_from.h"
#include "mpi/trace/trace_goal.h"
#include "mpi/trace/trace_run.h"

struct rmap_trace_session {
    const struct rmap_context *context;
    struct rmap_trace_request request;
    double begun;         /* rmap_clock_seconds */
    double until_tracing; /* seconds from then to the first block handed out */
    struct rmap_bundle *bundle;
    struct rmap_scene *scene; /* of the command line */
    struct rmap_accel *accel;
    struct rmap_run run;
    struct rmap_trace_goal goal;
    struct rmap_trace_from from;
    char parent[33]; /* digest of the map that rays of this one were taken over from; "": none */
    struct rmap_map_lock lock;         /* rank 0: nobody else writes to the map */
    struct rmap_map_listing found;     /* rank 0: what stood in the map before it was opened */
    struct rmap_map_content content;   /* rank 0: pieces of the map to be */
    struct rmap_trace_outcome outcome; /* of all requests so far; its tally on rank 0 alone */
};

/* Collective. The map stands, and says what it is to hold. */
enum rmap_status rmap_trace_session_begin(struct rmap_trace_session *session,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Collective. */
enum rmap_status rmap_trace_session_run(struct rmap_trace_session *session,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Collective: the balance, the index, the summary. RMAP_STOPPED when rays are still missing. */
enum rmap_status rmap_trace_session_conclude(struct rmap_trace_session *session,
                                             struct rmap_error *err) RMAP_MUST_USE;

void rmap_trace_session_fini(struct rmap_trace_session *session);

#endif
