/* SPDX-License-Identifier: MIT
 *
 * The part of a trace between its start and its conclusion.
 */
#ifndef RMAP_TRACE_PHASE_H
#define RMAP_TRACE_PHASE_H

#include "mpi/trace/trace_session.h"

/* Number of the shard that this rank writes. */
int rmap_trace_session_shard(const struct rmap_trace_session *session);

/* Collective; for rmap_trace_session_run. One request's missing rays join the outcome and the
 * content; with `recounts`, sums that nobody kept are made as well. */
enum rmap_status rmap_trace_phase_run(struct rmap_trace_session *session,
                                      const struct rmap_trace_phase *phase, bool recounts,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
