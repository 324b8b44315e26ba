/* SPDX-License-Identifier: MIT
 *
 * What the thread that calls MPI does while its rank's workers trace: it fetches work, passes
 * blocks on to the node's writer or takes them, stores chunks, and watches for signals, the time
 * limit and failures.
 */
#include "mpi/trace/trace_serve.h"

#include "io/write/shard_writer.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/nap.h"

/* Two blocks per worker lie ready, so that nobody waits for the counter; when blocks take long,
 * fewer, so that no rank ends with work in its queue while others have none. */
static size_t queue_target(const struct rmap_trace_serve *self)
{
    const double slow_s = 0.02;
    size_t n = (size_t)self->context->n_thread;
    return rmap_trace_workers_pace(self->workers) > slow_s ? n / 8 + 1 : 2 * n;
}

/* Blocks of other ranks are taken while fewer than this wait. */
static size_t inbox_max(const struct rmap_trace_serve *self)
{
    return 4 * (size_t)self->context->n_thread + 4;
}

size_t rmap_trace_serve_queue_cap(const struct rmap_trace_serve *self)
{
    const size_t margin = 8;
    return inbox_max(self) + 2 * (size_t)self->context->n_thread + margin;
}

/* Numbers that this rank would like to have: none while work for a moment is at hand, else work for
 * some moments, so that rank 0 is not asked for each block; it gives less when little is left. */
static uint64_t wanted(struct rmap_trace_serve *self, const struct rmap_blocks *from)
{
    const double moment_s = 0.02, moments_s = 0.25;
    const double pace = rmap_trace_workers_pace(self->workers);
    const double per_second = pace > 0.0 ? self->context->n_thread / pace : 0.0;
    const size_t target = queue_target(self);
    const double have = (double)(rmap_block_queue_length(&self->queue) + rmap_blocks_at_hand(from));
    if (have >= (double)target && have >= moment_s * per_second)
        return 0;
    return moments_s * per_second > (double)target ? (uint64_t)(moments_s * per_second) : target;
}

static enum rmap_status serve_others(struct rmap_trace_serve *self, bool want,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_blocks_serve(self->recounts, want ? wanted(self, self->recounts) : 0, 0, err));
    RMAP_TRY(rmap_blocks_serve(self->blocks, want ? wanted(self, self->blocks) : 0,
                               rmap_trace_workers_traced(self->workers), err));
    if (self->context->rank == 0)
        rmap_progress_show(&self->progress, rmap_blocks_done(self->blocks));
out:
    return st;
}

/* Parts to be summed up again and blocks to be traced take turns. */
static void fill_queue(struct rmap_trace_serve *self)
{
    uint64_t number = 0;
    while (rmap_block_queue_length(&self->queue) < queue_target(self)) {
        self->turn = !self->turn;
        struct rmap_blocks *first = self->turn ? self->recounts : self->blocks;
        struct rmap_blocks *second = self->turn ? self->blocks : self->recounts;
        struct rmap_blocks *from = rmap_blocks_at_hand(first) > 0 ? first : second;
        if (!rmap_blocks_take(from, &number))
            break;
        const enum rmap_work work = from == self->blocks ? RMAP_WORK_TRACE : RMAP_WORK_RECOUNT;
        rmap_block_queue_push(&self->queue,
                              (struct rmap_work_item){.work = work, .number = number});
    }
}

static bool nothing_left(const struct rmap_trace_serve *self)
{
    return rmap_blocks_ended(self->blocks) && rmap_blocks_ended(self->recounts);
}

/* Blocks of other ranks: in, when there is room, or out. */
static enum rmap_status pass_blocks(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_forward *forward = self->plan->forward;
    struct rmap_message *message = NULL;
    if (!forward)
        return RMAP_OK;
    if (!rmap_forward_writes(forward))
        return rmap_forward_send(forward, rmap_trace_workers_done(self->workers), err);
    do {
        bool hold = rmap_block_queue_length(&self->queue) >= inbox_max(self);
        if (rmap_block_queue_length(&self->queue) + 1 >= rmap_trace_serve_queue_cap(self))
            break;
        RMAP_TRY(rmap_forward_receive(forward, hold, &message, err));
        if (message)
            rmap_block_queue_push(
                &self->queue, (struct rmap_work_item){.work = RMAP_WORK_STORE, .message = message});
    } while (message);
out:
    return st;
}

/* Whether this rank, or another one, was asked to stop. */
static bool must_stop(const struct rmap_trace_serve *self)
{
    const double deadline = self->plan->deadline;
    return (deadline > 0.0 && rmap_clock_seconds() > deadline) ||
           rmap_trace_workers_failed(self->workers) || rmap_interrupt_caught() ||
           rmap_blocks_stopped(self->blocks);
}

/* Signals, the time limit and failures end the handing out of blocks for every rank; blocks in
 * hand are finished, unless their rays are so slow that it takes more than a moment. What is to be
 * summed up again is finished too, unless something failed. */
static void check_stop(struct rmap_trace_serve *self)
{
    const double grace_s = 5.0;
    if (self->asked_to_stop) {
        if (rmap_clock_seconds() > self->asked_at + grace_s)
            rmap_trace_workers_leave(self->workers);
    } else if (must_stop(self)) {
        self->asked_to_stop = true;
        self->asked_at = rmap_clock_seconds();
        rmap_blocks_stop(self->blocks);
    }
    if (rmap_trace_workers_failed(self->workers))
        rmap_blocks_stop(self->recounts);
}

/* The workers go home when there is no more work, from nobody. */
static void check_end(struct rmap_trace_serve *self)
{
    const struct rmap_forward *forward = self->plan->forward;
    bool ended = nothing_left(self);
    if (rmap_forward_writes(forward))
        ended = ended && rmap_forward_done(forward);
    if (!ended || self->closed)
        return;
    self->closed = true;
    rmap_block_queue_close(&self->queue);
}

enum rmap_status rmap_trace_serve_poll(struct rmap_trace_serve *self, struct rmap_error *err)
{
    check_stop(self);
    return serve_others(self, false, err);
}

/* Nobody waits for what will never be stored. */
static void give_up(struct rmap_trace_serve *self)
{
    rmap_trace_workers_abandon(self->workers);
    rmap_block_queue_discard(&self->queue);
    rmap_block_queue_close(&self->queue);
    self->closed = true;
    rmap_blocks_stop(self->blocks);
    rmap_blocks_stop(self->recounts);
}

/* Alone, nothing is asked of this thread between two blocks but to store chunks; with other ranks
 * it answers them. Every waking takes a core from a worker. */
static void rest(struct rmap_trace_serve *self)
{
    const int alone_ms = 10;
    if (self->context->size > 1 || self->closed || nothing_left(self))
        rmap_nap();
    else
        rmap_block_queue_rest(&self->queue, (queue_target(self) + 1) / 2, alone_ms);
}

enum rmap_status rmap_trace_serve(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (!rmap_trace_workers_done(self->workers)) {
        check_stop(self);
        RMAP_TRY(serve_others(self, true, err));
        fill_queue(self);
        RMAP_TRY(pass_blocks(self, err));
        if (self->plan->writer)
            RMAP_TRY(rmap_shard_writer_store(self->plan->writer, err));
        check_end(self);
        rest(self);
    }
    check_stop(self); /* all workers failed at once: the other ranks stop too */
out:
    if (st != RMAP_OK)
        give_up(self);
    return st;
}

enum rmap_status rmap_trace_serve_drain(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_forward *forward = self->plan->forward;
    while (!rmap_forward_done(forward)) {
        if (rmap_forward_writes(forward)) /* it failed: the run is lost */
            RMAP_TRY(rmap_forward_discard(forward, err));
        else
            RMAP_TRY(rmap_forward_send(forward, true, err));
        RMAP_TRY(rmap_trace_serve_poll(self, err));
        rmap_nap();
    }
out:
    return st;
}
