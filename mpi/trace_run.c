/* SPDX-License-Identifier: MIT */
#include "mpi/trace_run.h"

#include <time.h>

#include "mpi/agree.h"
#include "mpi/blocks.h"
#include "mpi/interrupt.h"
#include "mpi/progress.h"
#include "mpi/trace_workers.h"

struct run {
    const struct rmap_context *context;
    const struct rmap_trace_plan *plan;
    struct rmap_blocks *blocks;
    struct rmap_block_queue queue;
    struct rmap_trace_workers *workers;
    struct rmap_progress progress;
    struct rmap_ray_plan rays;
    bool ending; /* no more blocks are fetched */
};

static void nap(void)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    (void)nanosleep(&millisecond, NULL);
}

/* Two blocks per worker lie ready, so that nobody waits for the counter; when blocks take long,
 * fewer, so that no rank ends with work in its queue while others have none. */
static size_t queue_target(const struct run *run)
{
    const double slow_s = 0.02;
    size_t n = (size_t)run->context->n_thread;
    return rmap_trace_workers_pace(run->workers) > slow_s ? n / 8 + 1 : 2 * n;
}

static enum rmap_status fill_queue(struct run *run, struct rmap_error *err)
{
    while (!run->ending && rmap_block_queue_length(&run->queue) < queue_target(run)) {
        uint64_t block = run->rays.n_block;
        enum rmap_status st = rmap_blocks_next(run->blocks, &block, err);
        if (st != RMAP_OK)
            return st;
        if (block < run->rays.n_block) {
            rmap_block_queue_push(&run->queue, block);
        } else {
            rmap_block_queue_close(&run->queue);
            run->ending = true;
        }
    }
    return RMAP_OK;
}

/* Signals, the time limit and failures end the handing out for every rank; blocks in hand are
 * finished. */
static enum rmap_status check_stop(struct run *run, struct rmap_error *err)
{
    const struct rmap_trace_plan *plan = run->plan;
    bool late = plan->deadline > 0.0 && rmap_clock_seconds() > plan->deadline;
    if (run->ending ||
        !(late || rmap_interrupt_caught() || rmap_trace_workers_failed(run->workers)))
        return RMAP_OK;
    run->ending = true;
    rmap_block_queue_close(&run->queue);
    return rmap_blocks_stop(run->blocks, err);
}

/* What the calling thread does while the workers trace. */
static enum rmap_status serve(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t handed_out = 0;
    while (!rmap_trace_workers_done(run->workers)) {
        RMAP_TRY(fill_queue(run, err));
        if (run->plan->writer)
            RMAP_TRY(rmap_shard_writer_store(run->plan->writer, err));
        RMAP_TRY(check_stop(run, err));
        if (run->context->rank == 0) {
            RMAP_TRY(rmap_blocks_poll(run->blocks, &handed_out, err));
            rmap_progress_show(&run->progress, handed_out * RMAP_BLOCK_RAYS);
        }
        nap();
    }
out:
    if (st != RMAP_OK) { /* nobody waits for what will never be stored */
        struct rmap_error ignored = {0};
        rmap_trace_workers_abandon(run->workers);
        rmap_block_queue_discard(&run->queue);
        rmap_block_queue_close(&run->queue);
        if (!run->ending && rmap_blocks_stop(run->blocks, &ignored) != RMAP_OK)
            run->ending = true;
    }
    return st;
}

/* Collective. Waits for all ranks without taking a core from those that still work. */
static enum rmap_status wait_for_all(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Request request;
    int done = 0;
    uint64_t handed_out = 0;
    RMAP_TRY(RMAP_MPI(MPI_Ibarrier(run->context->comm, &request)));
    for (;;) {
        RMAP_TRY(RMAP_MPI(MPI_Test(&request, &done, MPI_STATUS_IGNORE)));
        if (done)
            break;
        if (run->context->rank == 0) {
            RMAP_TRY(rmap_blocks_poll(run->blocks, &handed_out, err));
            rmap_progress_show(&run->progress, handed_out * RMAP_BLOCK_RAYS);
        }
        nap();
    }
out:
    return st;
}

/* Collective. All sums are whole numbers far below 2^53, so adding them in any order is exact. */
static enum rmap_status reduce_tally(const struct rmap_context *context, struct rmap_tally *tally,
                                     struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 24;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < tally->n_value; at += piece) {
        size_t n = tally->n_value - at < piece ? tally->n_value - at : piece;
        const void *from = context->rank == 0 ? MPI_IN_PLACE : tally->value + at;
        RMAP_TRY(RMAP_MPI(
            MPI_Reduce(from, tally->value + at, (int)n, MPI_DOUBLE, MPI_SUM, 0, context->comm)));
    }
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, &tally->first_error_ray, 1, MPI_UINT64_T, MPI_MIN,
                                    context->comm)));
out:
    return st;
}

/* Collective. */
static enum rmap_status reduce_outcome(const struct rmap_context *context,
                                       struct rmap_trace_outcome *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int most[1] = {outcome->interrupt};
    RMAP_TRY(reduce_tally(context, outcome->tally, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_ray, 1, MPI_UINT64_T, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->seconds, 1, MPI_DOUBLE, MPI_MAX, context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_thread, 1, MPI_INT, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPI_INT, MPI_MAX, context->comm)));
    outcome->interrupt = most[0];
out:
    return st;
}

static enum rmap_status start(struct run *run, struct rmap_error *err)
{
    size_t cap = 2 * (size_t)run->context->n_thread + 2;
    enum rmap_status st = rmap_block_queue_init(&run->queue, cap, err);
    if (st == RMAP_OK)
        st = rmap_trace_workers_start(run->plan, &run->rays, run->context->n_thread, &run->queue,
                                      &run->workers, err);
    return rmap_agree(run->context, st, err);
}

/* This rank's part: work, join, last chunks on disk. */
static enum rmap_status work_through(struct run *run, struct rmap_trace_outcome *outcome,
                                     struct rmap_error *err)
{
    struct rmap_error worker_error = {0};
    enum rmap_status st = serve(run, err);
    enum rmap_status worker_st =
        rmap_trace_workers_join(run->workers, &outcome->tally, &outcome->n_ray, &worker_error);
    if (st == RMAP_OK && worker_st != RMAP_OK) {
        *err = worker_error;
        st = worker_st;
    }
    if (st == RMAP_OK && run->plan->writer)
        st = rmap_shard_writer_finish(run->plan->writer, err);
    return st;
}

enum rmap_status rmap_trace_run(const struct rmap_context *context,
                                const struct rmap_trace_plan *plan,
                                struct rmap_trace_outcome *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct run run = {.context = context, .plan = plan};
    double begun = rmap_clock_seconds();
    *outcome = (struct rmap_trace_outcome){.n_thread = context->n_thread};
    outcome->n_wanted = rmap_ray_set_count(plan->rays);
    rmap_interrupt_watch();
    RMAP_TRY(rmap_agree(context, rmap_ray_plan_init(&run.rays, plan->rays, err), err));
    RMAP_TRY(rmap_blocks_create(context, run.rays.n_block, &run.blocks, err));
    rmap_progress_init(&run.progress, context, "rays", run.rays.n_ray);
    st = start(&run, err);
    if (st != RMAP_OK)
        rmap_block_queue_close(&run.queue); /* a rank whose workers did start lets them go */
    RMAP_TRY(st);
    st = work_through(&run, outcome, err);
    outcome->seconds = rmap_clock_seconds() - begun;
    outcome->interrupt = rmap_interrupt_caught();
    struct rmap_error wait_error = {0};
    enum rmap_status wait_st = wait_for_all(&run, &wait_error);
    if (st == RMAP_OK && wait_st != RMAP_OK) {
        *err = wait_error;
        st = wait_st;
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(reduce_outcome(context, outcome, err));
out:
    rmap_progress_fini(&run.progress);
    rmap_trace_workers_destroy(run.workers);
    rmap_block_queue_fini(&run.queue);
    rmap_blocks_destroy(run.blocks);
    rmap_ray_plan_fini(&run.rays);
    if (st != RMAP_OK) {
        rmap_tally_destroy(outcome->tally);
        outcome->tally = NULL;
    }
    return st;
}
