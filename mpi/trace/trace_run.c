/* SPDX-License-Identifier: MIT
 *
 * Tracing a set of ray ids on all ranks: workers trace, record and encode, the calling thread
 * takes blocks from the common counter, stores encoded chunks, shows progress and watches for
 * signals and the time limit.
 */
#include "mpi/trace/trace_run.h"

#include "io/write/shard_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/tally_reduce.h"
#include "mpi/parallel/watchdog.h"
#include "mpi/trace/trace_serve.h"

/* Rank 0. Past the time limit, all ranks but silent ones have closed their pieces. */
static enum rmap_status leave_silent(struct rmap_trace_serve *run, struct rmap_error *err)
{
    const char *host = "";
    double deadline = run->plan->deadline;
    if (deadline <= 0.0 || rmap_clock_seconds() < deadline + rmap_watchdog_grace_s())
        return RMAP_OK;
    int missing = rmap_watchdog_missing(run->context->watchdog, &host);
    return missing > 0 ? rmap_survivors_gather(run->context, missing, host, rmap_watchdog_grace_s(),
                                               &run->survivors, err)
                       : RMAP_OK;
}

/* RMAP_STOPPED: nobody waits for all any more. */
static enum rmap_status poll_run(void *context, struct rmap_error *err)
{
    struct rmap_trace_serve *run = context;
    enum rmap_status st = run->context->rank == 0
                              ? leave_silent(run, err)
                              : rmap_survivors_heed(run->context, &run->survivors, err);
    if (st == RMAP_OK && run->survivors.missing > 0)
        return rmap_error_set(err, RMAP_STOPPED, "rank %d does not answer", run->survivors.missing);
    return st == RMAP_OK ? rmap_trace_serve_poll(run, err) : st;
}

/* Collective. */
static enum rmap_status wait_for_all(struct rmap_trace_serve *run, struct rmap_error *err)
{
    struct rmap_blocks *const blocks[] = {run->blocks, run->recounts};
    rmap_watchdog_set_done(run->context->watchdog, true);
    enum rmap_status st = rmap_blocks_wait_for_all(run->context, blocks, 2, poll_run, run, err);
    rmap_watchdog_set_done(run->context->watchdog, false);
    return st;
}

/* Collective. */
static enum rmap_status reduce_outcome(const struct rmap_context *context,
                                       struct rmap_trace_outcome *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int most[1] = {outcome->interrupt};
    RMAP_TRY(rmap_tally_reduce(context, outcome->tally, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_ray, 1, MPI_UINT64_T, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_reused, 1, MPI_UINT64_T, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->seconds, 1, MPI_DOUBLE, MPI_MAX, context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_thread, 1, MPI_INT, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPI_INT, MPI_MAX, context->comm)));
    outcome->interrupt = most[0];
out:
    return st;
}

static enum rmap_status start(struct rmap_trace_serve *run, struct rmap_error *err)
{
    enum rmap_status st = rmap_block_queue_init(&run->queue, rmap_trace_serve_queue_cap(run), err);
    if (st == RMAP_OK)
        st = rmap_trace_workers_start(run->plan, &run->rays, run->context->n_thread, &run->queue,
                                      &run->workers, err);
    return rmap_agree(run->context, st, err);
}

/* The first of two errors stays. */
static enum rmap_status first_of(enum rmap_status first, enum rmap_status second,
                                 const struct rmap_error *second_error, struct rmap_error *err)
{
    if (first != RMAP_OK || second == RMAP_OK)
        return first;
    *err = *second_error;
    return second;
}

/* This rank's part: work, join, last chunks on disk. */
static enum rmap_status work_through(struct rmap_trace_serve *run,
                                     struct rmap_trace_outcome *outcome, struct rmap_error *err)
{
    struct rmap_error worker_error = {0}, drain_error = {0};
    enum rmap_status st = rmap_trace_serve(run, err);
    enum rmap_status worker_st =
        rmap_trace_workers_join(run->workers, &outcome->tally, &outcome->n_ray, &worker_error);
    outcome->n_reused = rmap_trace_workers_reused(run->workers);
    st = first_of(st, worker_st, &worker_error, err);
    enum rmap_status drain_st = rmap_trace_serve_drain(run, &drain_error);
    st = first_of(st, drain_st, &drain_error, err);
    if (st == RMAP_OK && run->plan->writer)
        st = rmap_trace_encode_rest(run->plan->writer, run->context->n_thread, err);
    if (st == RMAP_OK && run->plan->writer)
        st = rmap_shard_writer_finish(run->plan->writer, err);
    return st;
}

/* Collective. The counters of what there is to do. */
static enum rmap_status create_counters(struct rmap_trace_serve *run, struct rmap_error *err)
{
    const struct rmap_context *context = run->context;
    enum rmap_status st = rmap_ray_plan_init(&run->rays, run->plan->rays, err);
    RMAP_TRY(rmap_agree(context, st, err));
    run->n_recount = (run->plan->recount.n + RMAP_PART_PORTIONS - 1) / RMAP_PART_PORTIONS;
    RMAP_TRY(rmap_blocks_create(context, run->rays.n_block, &run->blocks, err));
    RMAP_TRY(rmap_blocks_create(context, run->n_recount, &run->recounts, err));
out:
    return st;
}

enum rmap_status rmap_trace_run(const struct rmap_context *context,
                                const struct rmap_trace_plan *plan,
                                struct rmap_trace_outcome *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_trace_serve run = {.context = context, .plan = plan};
    double begun = rmap_clock_seconds();
    *outcome = (struct rmap_trace_outcome){.n_thread = context->n_thread};
    outcome->n_wanted = rmap_ray_set_count(plan->rays);
    RMAP_TRY(create_counters(&run, err));
    rmap_progress_init(&run.progress, context, "rays", run.rays.n_ray);
    st = start(&run, err);
    if (st != RMAP_OK)
        rmap_block_queue_close(&run.queue); /* a rank whose workers did start lets them go */
    RMAP_TRY(st);
    st = work_through(&run, outcome, err);
    outcome->seconds = rmap_clock_seconds() - begun;
    struct rmap_error wait_error = {0};
    enum rmap_status wait_st = wait_for_all(&run, &wait_error);
    outcome->interrupt =
        rmap_interrupt_caught(); /* while it waited, too: that stopped the others */
    outcome->survivors = run.survivors;
    if (wait_st == RMAP_STOPPED && run.survivors.missing > 0) {
        context = &outcome->survivors.context;
        wait_st = RMAP_OK;
    }
    st = first_of(st, wait_st, &wait_error, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(reduce_outcome(context, outcome, err));
out:
    rmap_progress_fini(&run.progress);
    rmap_trace_workers_destroy(run.workers);
    rmap_block_queue_fini(&run.queue);
    rmap_blocks_destroy(run.recounts);
    rmap_blocks_destroy(run.blocks);
    rmap_ray_plan_fini(&run.rays);
    if (st != RMAP_OK) {
        rmap_tally_destroy(outcome->tally);
        outcome->tally = NULL;
    }
    return st;
}
