/* SPDX-License-Identifier: MIT
 *
 * A sweep on all ranks: groups of ranks take variants in turn, and each commits its answers to a
 * journal of its own in the sweep's folder, so that a killed sweep goes on where it was.
 */
#ifndef RMAP_SWEEP_RUN_H
#define RMAP_SWEEP_RUN_H

#include "analysis/sweep/sweep_table.h"
#include "io/map/map_lock.h"
#include "mpi/command/command.h"

/* What took how many seconds by the clock. */
struct rmap_sweep_times {
    double all, scenes, trees, tracing, answers; /* trees: for the search of surfaces */
};

struct rmap_sweep_run {
    const struct rmap_context *context;
    struct rmap_sweep *sweep;
    struct rmap_bundle *bundle; /* of the nominal scene */
    const char *scene_path;     /* to read it again where variants cannot share files */
    const char *folder;         /* of the results */
    bool is_resumed, is_forced;
    struct rmap_map_lock lock;     /* rank 0: of the folder; whoever began the run releases it */
    struct rmap_sweep_table table; /* complete on rank 0 after the run */
    struct rmap_sweep_times times; /* of this rank's group */
    uint64_t n_reused;             /* rays that were taken over from the variant before */
};

/* Collective. RMAP_INPUT where the folder to be gone on with is another sweep's; RMAP_USAGE where
 * another command writes to it; RMAP_STOPPED after a signal. rmap_sweep_table_fini of the table
 * whatever happened. */
enum rmap_status rmap_sweep_run(struct rmap_sweep_run *run, struct rmap_error *err) RMAP_MUST_USE;

#endif
