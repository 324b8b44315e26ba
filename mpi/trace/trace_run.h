/* SPDX-License-Identifier: MIT
 *
 * Tracing a set of ray ids on all ranks: workers trace, record and encode, the calling thread
 * takes blocks from the common counter, stores encoded chunks, shows progress and watches for
 * signals and the time limit.
 */
#ifndef RMAP_TRACE_RUN_H
#define RMAP_TRACE_RUN_H

#include "accel/accel.h"
#include "io/map/map_reader.h"
#include "io/map/map_writer.h"
#include "mpi/parallel/survivors.h"
#include "mpi/trace/forward.h"
#include "mpi/trace/trace_reuse.h"
#include "portion/ray_plan.h"
#include "trace/tally.h"

/* Portions of an older run whose sums nobody kept: added up again while the trace goes on. */
struct rmap_trace_recount {
    const struct rmap_map *map; /* NULL: nothing to do */
    const size_t *portion;      /* [n] */
    size_t n;
};

struct rmap_trace_plan {
    const struct rmap_scene *scene;
    const struct rmap_accel *accel;
    uint64_t seed;
    const struct rmap_ray_set *rays;   /* to be traced; the same on every rank */
    double deadline;                   /* of rmap_clock_seconds; 0: none */
    struct rmap_shard_writer *writer;  /* this rank's; NULL: nothing is recorded, or others write */
    struct rmap_forward *forward;      /* NULL: every rank writes for itself */
    struct rmap_trace_recount recount; /* the same on every rank */
    const struct rmap_reuse *reuse;    /* rays that need not be traced; NULL: all must be */
};

struct rmap_trace_outcome {
    struct rmap_tally *tally; /* rank 0: of all ranks, recounted portions included. Other ranks:
                                 their own. */
    uint64_t n_wanted;        /* rays of the plan */
    uint64_t n_ray;           /* traced by all ranks; less than wanted when stopped */
    uint64_t n_reused;        /* of them, those that were taken over */
    double seconds;           /* of the slowest rank, its shard's last chunk stored */
    int interrupt;            /* signal that stopped it; 0: none */
    int n_thread;             /* of all ranks */
    struct rmap_survivors survivors; /* of whom it is the outcome, when a rank did not answer */
};

/* Collective. RMAP_SYSTEM when memory or a disk fails on any rank; rays that were stopped by a
 * signal or the deadline are no error. The caller destroys the tally. When a rank does not answer
 * long after the deadline, the survivors return, and everything afterwards is among them. */
enum rmap_status rmap_trace_run(const struct rmap_context *context,
                                const struct rmap_trace_plan *plan,
                                struct rmap_trace_outcome *outcome,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
