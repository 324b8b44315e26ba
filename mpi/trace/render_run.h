/* SPDX-License-Identifier: MIT
 *
 * A picture, rendered on all ranks in passes over its tiles. The number of passes and what each
 * adds depend on the samples wanted alone, and every pixel of a pass is one rank's work: any
 * number of ranks, threads and steps gives the same bits.
 */
#ifndef RMAP_RENDER_RUN_H
#define RMAP_RENDER_RUN_H

#include "mpi/command/command.h"
#include "mpi/trace/render_pass.h"

struct rmap_render_plan {
    const struct rmap_renderer *renderer;
    uint64_t n_sample;   /* per pixel */
    double time_limit_s; /* 0: none. The first pass is finished all the same */

    /* On rank 0, after each pass, with all samples so far; in steps, of 1, 4, 16, ... and all. */
    enum rmap_status (*show)(void *self, const struct rmap_film *film, struct rmap_error *err);
    void *self;
};

struct rmap_render_run {
    const struct rmap_context *context;
    struct rmap_render_plan plan;
    struct rmap_progress progress;
    struct rmap_render_pass pass;          /* under way, or over */
    struct rmap_render_counts pass_counts; /* of its tiles so far */
    double end;                            /* on rmap_clock_seconds; 0: no time limit */
    uint64_t n_done;                       /* samples, of passes that are over */
    double pace;                           /* samples of tiles a second of free cores; 0: unknown */
    bool is_over;

    struct rmap_film *film; /* on rank 0: of all passes that are over */
    struct rmap_render_counts counts;
    double seconds; /* spent rendering and gathering */
    int n_thread;   /* of all ranks */
    int interrupt;  /* number of a signal that came to any rank, or 0 */
};

/* Collective. To be ended also where it failed. */
enum rmap_status rmap_render_begin(const struct rmap_context *context,
                                   const struct rmap_render_plan *plan, struct rmap_render_run *run,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Goes on for about so many seconds, or to the next picture to be shown; 0: until it is
 * over. RMAP_INPUT: nobody wants the picture any longer. */
enum rmap_status rmap_render_step(struct rmap_render_run *run, double seconds,
                                  struct rmap_error *err) RMAP_MUST_USE;

void rmap_render_end(struct rmap_render_run *run);

#endif
