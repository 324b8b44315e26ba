/* SPDX-License-Identifier: MIT
 *
 * One pass over a picture's tiles, handed out to ranks by a counter and to threads by a queue.
 */
#include "mpi/trace/render_pass.h"

#include <stdatomic.h>
#include <time.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/block_queue.h"
#include "mpi/parallel/blocks.h"
#include "mpi/parallel/interrupt.h"

/* Who is told to stop finishes the tiles in hand if they are soon done; half a pass is none. */
#define GRACE_S 0.5

struct run {
    struct rmap_render_pass *pass;
    struct rmap_block_queue queue;
    struct rmap_blocks *tiles;
    struct rmap_workers *threads;
    struct rmap_render_counts *counts; /* [n_thread] */
    _Atomic uint64_t n_tile, busy_ns;  /* of this rank */
    double stop_by;                    /* by the clock; 0: nobody said stop */
    atomic_bool stop;                  /* at the next pixel */
};

static void work(void *context, int thread)
{
    struct run *run = context;
    struct rmap_render_counts *counts = &run->counts[thread];
    struct rmap_work_item item;
    struct timespec busy;
    while (rmap_block_queue_pop(&run->queue, &item)) {
        if (rmap_film_render_tile(run->pass->film, run->pass->renderer,
                                  run->pass->first_tile + item.number, run->pass->first,
                                  run->pass->n, &run->stop, counts))
            atomic_fetch_add(&run->n_tile, 1);
    }
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &busy) == 0) /* it lives for this pass */
        atomic_fetch_add(&run->busy_ns,
                         (uint64_t)busy.tv_sec * 1000000000 + (uint64_t)busy.tv_nsec);
    rmap_block_queue_knock(&run->queue);
}

/* Two tiles per thread lie ready. */
static size_t queue_target(const struct run *run)
{
    return 2 * (size_t)run->pass->context->n_thread;
}

static enum rmap_status serve_others(struct run *run, bool want, struct rmap_error *err)
{
    const struct rmap_render_pass *pass = run->pass;
    const size_t have = rmap_block_queue_length(&run->queue) + rmap_blocks_at_hand(run->tiles);
    const size_t target = queue_target(run);
    enum rmap_status st = rmap_blocks_serve(run->tiles, want && have < target ? target : 0,
                                            atomic_load(&run->n_tile), err);
    if (st == RMAP_OK && pass->context->rank == 0)
        rmap_progress_show(pass->progress,
                           rmap_film_n_tile(pass->film) * pass->first +
                               (pass->first_tile + rmap_blocks_done(run->tiles)) * pass->n);
    return st;
}

static void fill_queue(struct run *run)
{
    uint64_t tile;
    while (rmap_block_queue_length(&run->queue) < queue_target(run) &&
           rmap_blocks_take(run->tiles, &tile))
        rmap_block_queue_push(&run->queue,
                              (struct rmap_work_item){.work = RMAP_WORK_TRACE, .number = tile});
}

/* For all ranks no tile follows those in hand, and these are left when their time is over, or at
 * once where nobody wants the picture any longer. */
static void check_stop(struct run *run)
{
    const struct rmap_render_pass *pass = run->pass;
    double now = rmap_clock_seconds();
    bool late = pass->deadline > 0.0 && now > pass->deadline;
    const bool dropped = rmap_interrupt_stops_question();
    if (!late && !dropped && !rmap_interrupt_caught())
        return;
    if (!(run->stop_by > 0.0))
        run->stop_by = now + GRACE_S;
    if (dropped || now > run->stop_by) {
        atomic_store(&run->stop, true);
        rmap_block_queue_discard(&run->queue);
    }
    rmap_blocks_stop(run->tiles);
}

/* The thread that talks MPI, until this rank's workers are done. */
static enum rmap_status serve(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool closed = false;
    while (!rmap_workers_done(run->threads)) {
        check_stop(run);
        RMAP_TRY(serve_others(run, true, err));
        fill_queue(run);
        if (rmap_blocks_ended(run->tiles) && !closed) {
            rmap_block_queue_close(&run->queue);
            closed = true;
        }
        bool alone = run->pass->context->size == 1 && !closed;
        rmap_block_queue_rest(&run->queue, closed ? 0 : (queue_target(run) + 1) / 2,
                              alone ? 10 : 1);
    }
out:
    if (st != RMAP_OK) {
        rmap_blocks_stop(run->tiles);
        rmap_block_queue_discard(&run->queue);
        rmap_block_queue_close(&run->queue);
    }
    return st;
}

static enum rmap_status poll_run(void *run, struct rmap_error *err)
{
    return serve_others(run, false, err);
}

static enum rmap_status start(struct run *run, struct rmap_error *err)
{
    int n_thread = run->pass->context->n_thread;
    enum rmap_status st =
        rmap_block_queue_init(&run->queue, queue_target(run) + (size_t)n_thread, err);
    run->counts = rmap_alloc((size_t)n_thread, sizeof *run->counts);
    if (st == RMAP_OK && !run->counts)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    if (st == RMAP_OK)
        st = rmap_workers_start(n_thread, work, run, &run->threads, err);
    return rmap_agree(run->pass->context, st, err);
}

static void sum_up(struct run *run)
{
    struct rmap_render_pass *pass = run->pass;
    for (int i = 0; i < pass->context->n_thread; i++)
        rmap_render_counts_add(&pass->counts, &run->counts[i]);
    pass->n_tile = atomic_load(&run->n_tile);
    pass->busy_ns = atomic_load(&run->busy_ns);
}

enum rmap_status rmap_render_pass_run(struct rmap_render_pass *pass, struct rmap_error *err)
{
    struct run run = {.pass = pass};
    struct rmap_error wait_error = {0};
    pass->counts = (struct rmap_render_counts){0};
    pass->n_tile = pass->busy_ns = 0;
    enum rmap_status st =
        rmap_blocks_create(pass->context, pass->end_tile - pass->first_tile, &run.tiles, err);
    if (st == RMAP_OK && (st = start(&run, err)) == RMAP_OK) {
        st = serve(&run, err);
        rmap_workers_join(run.threads);
        run.threads = NULL;
        sum_up(&run);
        enum rmap_status waited =
            rmap_blocks_wait_for_all(pass->context, &run.tiles, 1, poll_run, &run, &wait_error);
        if (st == RMAP_OK && (st = waited) != RMAP_OK)
            *err = wait_error;
        st = rmap_agree(pass->context, st, err);
    } else if (run.threads) { /* of another rank's failure: they go home */
        rmap_block_queue_close(&run.queue);
    }
    rmap_workers_join(run.threads);
    rmap_block_queue_fini(&run.queue);
    rmap_blocks_destroy(run.tiles);
    rmap_free(run.counts);
    return st;
}
