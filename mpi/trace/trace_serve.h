/* SPDX-License-Identifier: MIT
 *
 * What the thread that calls MPI does while its rank's workers trace: it fetches work, passes
 * blocks on to the node's writer or takes them, stores chunks, and watches for signals, the time
 * limit and failures.
 */
#ifndef RMAP_TRACE_SERVE_H
#define RMAP_TRACE_SERVE_H

#include "mpi/parallel/blocks.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/trace_workers.h"

struct rmap_trace_serve {
    const struct rmap_context *context;
    const struct rmap_trace_plan *plan;
    struct rmap_ray_plan rays;
    uint64_t n_recount; /* parts */
    struct rmap_blocks *blocks, *recounts;
    struct rmap_block_queue queue;
    struct rmap_trace_workers *workers;
    struct rmap_progress progress;
    struct rmap_survivors survivors;
    bool closed, turn;
    bool asked_to_stop; /* by a signal, the time limit, a failure, or another rank */
    double asked_at;    /* seconds: when */
};

/* Until the workers are done. On failure they are told to stop, and no rank gets more work. */
enum rmap_status rmap_trace_serve(struct rmap_trace_serve *self,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Afterwards, whether it failed or not: no rank is left waiting for this one to take or send
 * blocks. */
enum rmap_status rmap_trace_serve_drain(struct rmap_trace_serve *self,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Often, while nothing is wanted: asks all ranks to stop when this one was asked; rank 0 answers
 * the others and shows progress. */
enum rmap_status rmap_trace_serve_poll(struct rmap_trace_serve *self,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Room in the queue for whatever may lie in it. */
size_t rmap_trace_serve_queue_cap(const struct rmap_trace_serve *self);

#endif
