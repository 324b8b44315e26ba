/* SPDX-License-Identifier: MIT
 *
 * Rays that come while a server answers: a trace into memory, slice by slice.
 */
#ifndef RMAP_SERVE_TRACE_H
#define RMAP_SERVE_TRACE_H

#include "mpi/serve/serve_state.h"

/* Collective; a request. {"rays", "seed", "action": "start" | "pause" | "resume" | "stop", "wait"}.
 */
enum rmap_status rmap_serve_trace(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Collective, while it is running: some tenths of a second of it. Says on failure so, and is over.
 */
enum rmap_status rmap_serve_trace_slice(struct rmap_serve *self,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* {"state", "rays", "of", "seed", "seconds"} */
json_t *rmap_serve_trace_json(const struct rmap_serve *self);

#endif
