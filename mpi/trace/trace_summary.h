/* SPDX-License-Identifier: MIT
 *
 * What `raymap trace` says when it is done.
 */
#ifndef RMAP_TRACE_SUMMARY_H
#define RMAP_TRACE_SUMMARY_H

#include "io/map/map_content.h"
#include "mpi/trace/trace_from.h"
#include "mpi/trace/trace_run.h"

struct rmap_trace_report {
    const struct rmap_trace_plan *plan; /* scene, structure and seed of rays that went wrong */
    const struct rmap_trace_outcome *outcome; /* its tally is of the whole map */
    const char *map_path;                     /* NULL: nothing was recorded; else: */
    const struct rmap_map_content *content;   /* of the map, summed up */
    uint64_t map_nbytes;                      /* with the index */
    uint64_t n_held;                          /* rays that the map held before */
    const struct rmap_trace_from *from;       /* NULL: the trace is from no other map; else: */
    const char *from_path;
    double until_tracing; /* seconds to read and prepare everything */
};

/* Not collective; rank 0. Text or, with --json, one document on stdout; nothing with --quiet
 * alone. */
enum rmap_status rmap_trace_summarise(const struct rmap_context *context,
                                      const struct rmap_trace_report *report,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
