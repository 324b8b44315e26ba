/* SPDX-License-Identifier: MIT */
#include "mpi/trace_serve.h"

#include "mpi/interrupt.h"

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

static enum rmap_status fetch(struct rmap_blocks *from, uint64_t n, enum rmap_work work,
                              struct rmap_trace_serve *self, bool *ended, struct rmap_error *err)
{
    uint64_t number = n;
    enum rmap_status st = rmap_blocks_next(from, &number, err);
    if (st != RMAP_OK)
        return st;
    if (number < n)
        rmap_block_queue_push(&self->queue,
                              (struct rmap_work_item){.work = work, .number = number});
    else
        *ended = true;
    return RMAP_OK;
}

/* Parts to be summed up again and blocks to be traced take turns. */
static enum rmap_status fill_queue(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (st == RMAP_OK && !(self->blocks_ended && self->recounts_ended) &&
           rmap_block_queue_length(&self->queue) < queue_target(self)) {
        self->turn = !self->turn;
        if (!self->recounts_ended && (self->turn || self->blocks_ended))
            st = fetch(self->recounts, self->n_recount, RMAP_WORK_RECOUNT, self,
                       &self->recounts_ended, err);
        else if (!self->blocks_ended)
            st = fetch(self->blocks, self->rays.n_block, RMAP_WORK_TRACE, self, &self->blocks_ended,
                       err);
    }
    return st;
}

/* Blocks of other ranks: in, when there is room, or out. */
static enum rmap_status pass_blocks(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_forward *forward = self->plan->forward;
    struct rmap_parcel *parcel = NULL;
    if (!forward)
        return RMAP_OK;
    if (!rmap_forward_writes(forward))
        return rmap_forward_send(forward, rmap_trace_workers_done(self->workers), err);
    do {
        bool hold = rmap_block_queue_length(&self->queue) >= inbox_max(self);
        if (rmap_block_queue_length(&self->queue) + 1 >= rmap_trace_serve_queue_cap(self))
            break;
        RMAP_TRY(rmap_forward_receive(forward, hold, &parcel, err));
        if (parcel)
            rmap_block_queue_push(
                &self->queue, (struct rmap_work_item){.work = RMAP_WORK_STORE, .parcel = parcel});
    } while (parcel);
out:
    return st;
}

/* Whether this rank, or another one, was asked to stop. A rank whose blocks take long fetches none
 * for a while: so it looks now and then. */
static enum rmap_status hear_stop(struct rmap_trace_serve *self, bool *asked,
                                  struct rmap_error *err)
{
    const double look_s = 0.5;
    double now = rmap_clock_seconds(), deadline = self->plan->deadline;
    *asked = (deadline > 0.0 && now > deadline) || rmap_trace_workers_failed(self->workers) ||
             rmap_interrupt_caught();
    if (*asked || self->context->size == 1 || now < self->looked_at + look_s)
        return RMAP_OK;
    self->looked_at = now;
    return rmap_blocks_stopped(self->blocks, asked, err);
}

/* Signals, the time limit and failures end the handing out of blocks for every rank; blocks in
 * hand are finished, unless their rays are so slow that it takes more than a moment. What is to be
 * summed up again is finished too, unless something failed. */
static enum rmap_status check_stop(struct rmap_trace_serve *self, struct rmap_error *err)
{
    const double grace_s = 5.0;
    enum rmap_status st = RMAP_OK;
    bool asked = false;
    if (self->asked_to_stop) {
        if (rmap_clock_seconds() > self->asked_at + grace_s)
            rmap_trace_workers_leave(self->workers);
    } else {
        RMAP_TRY(hear_stop(self, &asked, err));
        if (asked) {
            self->asked_to_stop = self->blocks_ended = true;
            self->asked_at = rmap_clock_seconds();
            RMAP_TRY(rmap_blocks_stop(self->blocks, err)); /* handed out or not: others look */
        }
    }
    if (!self->recounts_ended && rmap_trace_workers_failed(self->workers)) {
        self->recounts_ended = true;
        RMAP_TRY(rmap_blocks_stop(self->recounts, err));
    }
out:
    return st;
}

/* The workers go home when there is no more work, from nobody. */
static void check_end(struct rmap_trace_serve *self)
{
    const struct rmap_forward *forward = self->plan->forward;
    bool ended = self->blocks_ended && self->recounts_ended;
    if (rmap_forward_writes(forward))
        ended = ended && rmap_forward_done(forward);
    if (!ended || self->closed)
        return;
    self->closed = true;
    rmap_block_queue_close(&self->queue);
}

enum rmap_status rmap_trace_serve_poll(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t handed_out = 0;
    RMAP_TRY(check_stop(self, err));
    if (self->context->rank != 0)
        return RMAP_OK;
    RMAP_TRY(rmap_blocks_poll(self->blocks, &handed_out, err));
    rmap_progress_show(&self->progress, handed_out * RMAP_BLOCK_RAYS);
    if (self->n_recount > 0)
        RMAP_TRY(rmap_blocks_poll(self->recounts, &handed_out, err));
out:
    return st;
}

/* Nobody waits for what will never be stored. */
static void give_up(struct rmap_trace_serve *self)
{
    struct rmap_error ignored = {0};
    rmap_trace_workers_abandon(self->workers);
    rmap_block_queue_discard(&self->queue);
    rmap_block_queue_close(&self->queue);
    self->closed = self->blocks_ended = self->recounts_ended = true;
    /* When even this fails, the other ranks run into the failing MPI themselves. */
    if (rmap_blocks_stop(self->blocks, &ignored) != RMAP_OK ||
        rmap_blocks_stop(self->recounts, &ignored) != RMAP_OK)
        return;
}

/* Alone, nothing is asked of this thread between two blocks but to store chunks; with other ranks
 * it answers them. Every waking takes a core from a worker. */
static void rest(struct rmap_trace_serve *self)
{
    const int alone_ms = 10;
    bool busy =
        self->context->size > 1 || self->closed || (self->blocks_ended && self->recounts_ended);
    if (busy)
        rmap_trace_nap();
    else
        rmap_block_queue_rest(&self->queue, (queue_target(self) + 1) / 2, alone_ms);
}

enum rmap_status rmap_trace_serve(struct rmap_trace_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (!rmap_trace_workers_done(self->workers)) {
        RMAP_TRY(fill_queue(self, err));
        RMAP_TRY(pass_blocks(self, err));
        if (self->plan->writer)
            RMAP_TRY(rmap_shard_writer_store(self->plan->writer, err));
        RMAP_TRY(rmap_trace_serve_poll(self, err));
        check_end(self);
        rest(self);
    }
    RMAP_TRY(check_stop(self, err)); /* all workers failed at once: the other ranks stop too */
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
        rmap_trace_nap();
    }
out:
    return st;
}
