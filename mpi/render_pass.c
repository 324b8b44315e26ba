/* SPDX-License-Identifier: MIT */
#include "mpi/render_pass.h"

#include <stdatomic.h>
#include <time.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/agree.h"
#include "mpi/block_queue.h"
#include "mpi/blocks.h"
#include "mpi/interrupt.h"

/* Who is told to stop finishes the tiles in hand if they are soon done; half a pass is none. */
#define GRACE_S 0.5

struct worker {
    struct rmap_render_counts counts;
    uint64_t n_tile;
};

struct run {
    struct rmap_render_pass *pass;
    struct rmap_block_queue queue;
    struct rmap_blocks *tiles;
    struct rmap_workers *threads;
    struct worker *worker; /* [n_thread] */
    bool ended;            /* no tile will come */
    double stop_by;        /* by the clock; 0: nobody said stop */
    atomic_bool stop;      /* at the next pixel */
};

static void work(void *context, int thread)
{
    struct run *run = context;
    struct worker *self = &run->worker[thread];
    struct rmap_work_item item;
    while (rmap_block_queue_pop(&run->queue, &item)) {
        self->n_tile +=
            rmap_film_render_tile(run->pass->film, run->pass->renderer, item.number,
                                  run->pass->first, run->pass->n, &run->stop, &self->counts);
    }
    rmap_block_queue_knock(&run->queue);
}

/* Two tiles per thread lie ready. */
static size_t queue_target(const struct run *run)
{
    return 2 * (size_t)run->pass->context->n_thread;
}

static enum rmap_status fill_queue(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n = rmap_film_n_tile(run->pass->film), tile = n;
    while (!run->ended && rmap_block_queue_length(&run->queue) < queue_target(run)) {
        RMAP_TRY(rmap_blocks_next(run->tiles, &tile, err));
        if (tile < n)
            rmap_block_queue_push(&run->queue,
                                  (struct rmap_work_item){.work = RMAP_WORK_TRACE, .number = tile});
        else
            run->ended = true;
    }
out:
    return st;
}

/* For all ranks no tile follows those in hand, and these are left when their time is over. */
static enum rmap_status check_stop(struct run *run, struct rmap_error *err)
{
    const struct rmap_render_pass *pass = run->pass;
    double now = rmap_clock_seconds();
    bool late = pass->deadline > 0.0 && now > pass->deadline;
    if (!late && !rmap_interrupt_caught())
        return RMAP_OK;
    if (!(run->stop_by > 0.0))
        run->stop_by = now + GRACE_S;
    if (now > run->stop_by) {
        atomic_store(&run->stop, true);
        rmap_block_queue_discard(&run->queue);
    }
    if (run->ended)
        return RMAP_OK;
    run->ended = true;
    return rmap_blocks_stop(run->tiles, err);
}

static enum rmap_status answer_others(struct run *run, struct rmap_error *err)
{
    uint64_t handed_out = 0;
    if (run->pass->context->rank != 0)
        return RMAP_OK;
    enum rmap_status st = rmap_blocks_poll(run->tiles, &handed_out, err);
    if (st == RMAP_OK)
        rmap_progress_show(run->pass->progress,
                           rmap_film_n_tile(run->pass->film) * run->pass->first +
                               handed_out * run->pass->n);
    return st;
}

static void nap(void)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    (void)nanosleep(&millisecond, NULL);
}

/* The thread that talks MPI, until this rank's workers are done. */
static enum rmap_status serve(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool closed = false;
    while (!rmap_workers_done(run->threads)) {
        RMAP_TRY(check_stop(run, err));
        RMAP_TRY(fill_queue(run, err));
        if (run->ended && !closed) {
            rmap_block_queue_close(&run->queue);
            closed = true;
        }
        RMAP_TRY(answer_others(run, err));
        bool alone = run->pass->context->size == 1 && !closed;
        rmap_block_queue_rest(&run->queue, closed ? 0 : (queue_target(run) + 1) / 2,
                              alone ? 10 : 1);
    }
out:
    if (st != RMAP_OK) {
        rmap_block_queue_discard(&run->queue);
        rmap_block_queue_close(&run->queue);
    }
    return st;
}

/* Collective. Rank 0 goes on answering those that still ask for tiles. */
static enum rmap_status wait_for_all(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Request request;
    int done = 0;
    RMAP_TRY(RMAP_MPI(MPI_Ibarrier(run->pass->context->comm, &request)));
    for (;;) {
        RMAP_TRY(RMAP_MPI(MPI_Test(&request, &done, MPI_STATUS_IGNORE)));
        if (done)
            break;
        RMAP_TRY(answer_others(run, err));
        nap();
    }
out:
    return st;
}

static enum rmap_status start(struct run *run, struct rmap_error *err)
{
    int n_thread = run->pass->context->n_thread;
    enum rmap_status st =
        rmap_block_queue_init(&run->queue, queue_target(run) + (size_t)n_thread, err);
    run->worker = rmap_alloc((size_t)n_thread, sizeof *run->worker);
    if (st == RMAP_OK && !run->worker)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    if (st == RMAP_OK)
        st = rmap_workers_start(n_thread, work, run, &run->threads, err);
    return rmap_agree(run->pass->context, st, err);
}

static void sum_up(struct run *run)
{
    struct rmap_render_pass *pass = run->pass;
    for (int i = 0; i < pass->context->n_thread; i++) {
        rmap_render_counts_add(&pass->counts, &run->worker[i].counts);
        pass->n_tile += run->worker[i].n_tile;
    }
}

enum rmap_status rmap_render_pass_run(struct rmap_render_pass *pass, struct rmap_error *err)
{
    struct run run = {.pass = pass};
    struct rmap_error wait_error = {0};
    pass->counts = (struct rmap_render_counts){0};
    pass->n_tile = 0;
    enum rmap_status st =
        rmap_blocks_create(pass->context, rmap_film_n_tile(pass->film), &run.tiles, err);
    if (st == RMAP_OK && (st = start(&run, err)) == RMAP_OK) {
        st = serve(&run, err);
        rmap_workers_join(run.threads);
        run.threads = NULL;
        sum_up(&run);
        enum rmap_status waited = wait_for_all(&run, &wait_error);
        if (st == RMAP_OK && (st = waited) != RMAP_OK)
            *err = wait_error;
        st = rmap_agree(pass->context, st, err);
    } else if (run.threads) { /* of another rank's failure: they go home */
        rmap_block_queue_close(&run.queue);
    }
    rmap_workers_join(run.threads);
    rmap_block_queue_fini(&run.queue);
    rmap_blocks_destroy(run.tiles);
    rmap_free(run.worker);
    return st;
}
