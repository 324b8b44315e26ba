/* SPDX-License-Identifier: MIT
 *
 * One pass over a picture's tiles, handed out to ranks by a counter and to threads by a queue.
 */
#ifndef RMAP_RENDER_PASS_H
#define RMAP_RENDER_PASS_H

#include "mpi/parallel/progress.h"
#include "render/film.h"

struct rmap_render_pass {
    const struct rmap_context *context;
    const struct rmap_renderer *renderer;
    struct rmap_progress *progress; /* in tiles times samples */
    uint64_t first, n;              /* samples of every pixel */
    uint64_t first_tile, end_tile;  /* of it */
    double deadline;                /* on rmap_clock_seconds; 0: none */
    struct rmap_film *film;         /* cleared; this rank's tiles */
    struct rmap_render_counts counts;
    uint64_t n_tile;  /* done by this rank */
    uint64_t busy_ns; /* of its threads, by the processor: others may have the cores */
};

/* Collective. Of those tiles, with no others' counts. Ends early, with fewer tiles, at the deadline
 * or when a signal has come. */
enum rmap_status rmap_render_pass_run(struct rmap_render_pass *pass,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
