/* SPDX-License-Identifier: MIT
 *
 * A picture, rendered on all ranks in passes over its tiles. The number of passes and what each
 * adds depend on the samples wanted alone, and every pixel of a pass is one rank's work: any
 * number of ranks and threads gives the same bits.
 */
#ifndef RMAP_RENDER_RUN_H
#define RMAP_RENDER_RUN_H

#include "mpi/command/command.h"
#include "render/film.h"

struct rmap_render_plan {
    const struct rmap_renderer *renderer;
    uint64_t n_sample;   /* per pixel */
    double time_limit_s; /* 0: none. The first pass is finished all the same */

    /* On rank 0, after each pass, with all samples so far. */
    enum rmap_status (*show)(void *self, const struct rmap_film *film, struct rmap_error *err);
    void *self;
};

struct rmap_render_outcome {
    struct rmap_film *film; /* on rank 0; NULL when stopped before the first pass was over */
    struct rmap_render_counts counts;
    double seconds; /* spent rendering and gathering */
    int n_thread;   /* of all ranks */
    int interrupt;  /* number of a signal that came to any rank, or 0 */
};

/* Collective. The caller destroys the film. */
enum rmap_status rmap_render_run(const struct rmap_context *context,
                                 const struct rmap_render_plan *plan,
                                 struct rmap_render_outcome *outcome,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
