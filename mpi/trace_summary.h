/* SPDX-License-Identifier: MIT
 *
 * What `raymap trace` says when it is done.
 */
#ifndef RMAP_TRACE_SUMMARY_H
#define RMAP_TRACE_SUMMARY_H

#include "io/map_reader.h"
#include "mpi/trace_run.h"

/* Not collective; rank 0. map_path: NULL when nothing was recorded. Text or, with --json, one
 * document on stdout; nothing with --quiet alone. */
enum rmap_status rmap_trace_summarise(const struct rmap_context *context,
                                      const struct rmap_trace_plan *plan,
                                      const struct rmap_trace_outcome *outcome,
                                      const char *map_path, struct rmap_error *err) RMAP_MUST_USE;

#endif
