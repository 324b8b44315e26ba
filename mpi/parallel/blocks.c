/* SPDX-License-Identifier: MIT
 *
 * Handing out numbers (of blocks of rays, of tiles) to ranks: each asks rank 0 for some before
 * those that it has run out, and gets them in proportion to what is left, so that a fast rank
 * simply takes more of them.
 */
#include "mpi/parallel/blocks.h"

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/nap.h"
#include "mpi/parallel/progress.h"

/* Words of a question, and of its answer. */
enum { WANTED, DONE, STOP, N_QUESTION };
enum { FIRST, END, STOPPED, N_ANSWER };

struct range {
    uint64_t first, end;
};

/* Rank 0: what another rank was answered last, and has told. */
struct asker {
    uint64_t answer[N_ANSWER], n_done;
    MPI_Request sent;
};

struct rmap_blocks {
    MPI_Comm comm;
    int rank, size;
    /* of this rank */
    struct range now, then; /* numbers at hand, in this order */
    uint64_t n_done;
    bool none_left, stopped, stop_untold;
    uint64_t question[N_QUESTION], answer[N_ANSWER];
    MPI_Request sent, heard; /* MPI_REQUEST_NULL: no question is under way */
    double told_at, tell_s;
    /* of rank 0 */
    uint64_t next, n_block;
    uint64_t n_share; /* what is left is dealt in so many parts: of which each is asked for again */
    struct asker *asker; /* [size] */
};

/* Some thousand ranks that tell keep rank 0 from its work for a hundredth of its time. */
static double tell_interval(int size)
{
    const double usual_s = 0.5, per_rank_s = 5e-4;
    return size * per_rank_s > usual_s ? size * per_rank_s : usual_s;
}

enum rmap_status rmap_blocks_create(const struct rmap_context *context, uint64_t n_block,
                                    struct rmap_blocks **blocks_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_blocks *self = rmap_alloc(1, sizeof *self);
    if (self && context->rank == 0)
        self->asker = rmap_alloc((size_t)context->size, sizeof *self->asker);
    if (!self || (context->rank == 0 && !self->asker))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (self) {
        self->comm = MPI_COMM_NULL;
        self->sent = self->heard = MPI_REQUEST_NULL;
        for (int i = 0; self->asker && i < context->size; i++)
            self->asker[i].sent = MPI_REQUEST_NULL;
    }
    RMAP_TRY(rmap_agree(context, st, err));
    self->rank = context->rank;
    self->size = context->size;
    self->tell_s = tell_interval(context->size);
    self->n_block = n_block;
    self->none_left = n_block == 0;
    self->n_share = 2 * (uint64_t)context->n_thread;
    RMAP_TRY(RMAP_MPI(MPI_Comm_dup(context->comm, &self->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &self->n_share, 1, MPI_UINT64_T, MPI_SUM, self->comm)));
    *blocks_ret = self;
    self = NULL;
out:
    rmap_blocks_destroy(self);
    return st;
}

/* What is still under way is that of a run that failed. */
static void drop(MPI_Request *request)
{
    if (*request == MPI_REQUEST_NULL)
        return;
    (void)MPI_Cancel(request);
    (void)MPI_Request_free(request);
}

void rmap_blocks_destroy(struct rmap_blocks *self)
{
    if (!self)
        return;
    drop(&self->heard);
    if (self->sent != MPI_REQUEST_NULL)
        (void)MPI_Request_free(&self->sent);
    for (int i = 0; self->asker && i < self->size; i++)
        if (self->asker[i].sent != MPI_REQUEST_NULL)
            (void)MPI_Request_free(&self->asker[i].sent);
    if (self->comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&self->comm);
    rmap_free(self->asker);
    rmap_free(self);
}

/* ---- rank 0 ---- */

static void grant(struct rmap_blocks *self, uint64_t n_wanted, uint64_t answer[N_ANSWER])
{
    const uint64_t left = self->stopped ? 0 : self->n_block - self->next;
    uint64_t n = left / self->n_share;
    n = n > 0 ? n : 1;
    n = n < n_wanted ? n : n_wanted;
    n = n < left ? n : left;
    answer[FIRST] = self->next;
    answer[END] = self->next += n;
    answer[STOPPED] = self->stopped;
}

static enum rmap_status answer_others(struct rmap_blocks *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t question[N_QUESTION];
    MPI_Status status;
    int waiting = 1;
    for (;;) {
        RMAP_TRY(RMAP_MPI(MPI_Iprobe(MPI_ANY_SOURCE, 0, self->comm, &waiting, &status)));
        if (!waiting)
            break;
        struct asker *asker = &self->asker[status.MPI_SOURCE];
        RMAP_TRY(RMAP_MPI(MPI_Recv(question, N_QUESTION, MPI_UINT64_T, status.MPI_SOURCE, 0,
                                   self->comm, MPI_STATUS_IGNORE)));
        RMAP_TRY(RMAP_MPI(MPI_Wait(&asker->sent, MPI_STATUS_IGNORE))); /* it came: it asks again */
        asker->n_done = question[DONE];
        if (question[STOP])
            rmap_blocks_stop(self);
        grant(self, question[WANTED], asker->answer);
        RMAP_TRY(RMAP_MPI(MPI_Isend(asker->answer, N_ANSWER, MPI_UINT64_T, status.MPI_SOURCE, 0,
                                    self->comm, &asker->sent)));
    }
out:
    return st;
}

uint64_t rmap_blocks_done(const struct rmap_blocks *self)
{
    uint64_t n = self->n_done;
    for (int i = 1; i < self->size; i++)
        n += self->asker[i].n_done;
    return n;
}

/* ---- every rank ---- */

static void take_in(struct rmap_blocks *self, uint64_t n_wanted, const uint64_t answer[N_ANSWER])
{
    struct range *free_range = self->now.first < self->now.end ? &self->then : &self->now;
    if (answer[STOPPED])
        rmap_blocks_stop(self);
    if (self->stopped)
        return; /* what came meanwhile is nobody's */
    if (answer[FIRST] < answer[END])
        *free_range = (struct range){answer[FIRST], answer[END]};
    else
        self->none_left = self->none_left || n_wanted > 0;
}

static enum rmap_status hear(struct rmap_blocks *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int came = 0;
    if (self->heard == MPI_REQUEST_NULL)
        return RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Test(&self->heard, &came, MPI_STATUS_IGNORE)));
    if (!came)
        return RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Wait(&self->sent, MPI_STATUS_IGNORE)));
    take_in(self, self->question[WANTED], self->answer);
out:
    return st;
}

static enum rmap_status ask(struct rmap_blocks *self, uint64_t n_wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double now = rmap_clock_seconds();
    if (self->heard != MPI_REQUEST_NULL ||
        (n_wanted == 0 && !self->stop_untold && now < self->told_at + self->tell_s))
        return RMAP_OK;
    self->question[WANTED] = n_wanted;
    self->question[DONE] = self->n_done;
    self->question[STOP] = self->stop_untold;
    self->stop_untold = false;
    self->told_at = now;
    RMAP_TRY(
        RMAP_MPI(MPI_Irecv(self->answer, N_ANSWER, MPI_UINT64_T, 0, 0, self->comm, &self->heard)));
    RMAP_TRY(RMAP_MPI(
        MPI_Isend(self->question, N_QUESTION, MPI_UINT64_T, 0, 0, self->comm, &self->sent)));
out:
    return st;
}

enum rmap_status rmap_blocks_serve(struct rmap_blocks *self, uint64_t n_wanted, uint64_t n_done,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->n_done = n_done;
    if (self->rank != 0)
        RMAP_TRY(hear(self, err));
    else if (self->size > 1)
        RMAP_TRY(answer_others(self, err));
    if (self->none_left || self->then.first < self->then.end)
        n_wanted = 0;
    if (self->rank != 0)
        return ask(self, n_wanted, err);
    if (n_wanted > 0) {
        grant(self, n_wanted, self->answer);
        take_in(self, n_wanted, self->answer);
    }
out:
    return st;
}

bool rmap_blocks_take(struct rmap_blocks *self, uint64_t *number_ret)
{
    if (self->now.first == self->now.end) {
        self->now = self->then;
        self->then = (struct range){0};
    }
    if (self->now.first == self->now.end)
        return false;
    *number_ret = self->now.first++;
    return true;
}

uint64_t rmap_blocks_at_hand(const struct rmap_blocks *self)
{
    return self->now.end - self->now.first + self->then.end - self->then.first;
}

bool rmap_blocks_ended(const struct rmap_blocks *self)
{
    return self->none_left && rmap_blocks_at_hand(self) == 0;
}

void rmap_blocks_stop(struct rmap_blocks *self)
{
    if (self->stopped)
        return;
    self->stopped = self->none_left = true;
    self->stop_untold = self->rank != 0;
    self->now = self->then = (struct range){0};
}

bool rmap_blocks_stopped(const struct rmap_blocks *self)
{
    return self->stopped;
}

static bool is_talking(const struct rmap_blocks *self)
{
    return self->rank != 0 && (self->heard != MPI_REQUEST_NULL || self->stop_untold);
}

/* Collective. `serve` NULL: only waits. */
static enum rmap_status wait_for_ranks(const struct rmap_context *context,
                                       enum rmap_status (*serve)(void *self,
                                                                 struct rmap_error *err),
                                       void *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Request request = MPI_REQUEST_NULL;
    int done = 0;
    RMAP_TRY(RMAP_MPI(MPI_Ibarrier(context->comm, &request)));
    for (;;) {
        RMAP_TRY(RMAP_MPI(MPI_Test(&request, &done, MPI_STATUS_IGNORE)));
        if (done)
            break;
        if (serve)
            RMAP_TRY(serve(self, err));
        rmap_nap();
    }
out:
    return st;
}

enum rmap_status
rmap_blocks_wait_for_all(const struct rmap_context *context, struct rmap_blocks *const *blocks,
                         size_t n, enum rmap_status (*serve)(void *self, struct rmap_error *err),
                         void *self, struct rmap_error *err)
{
    enum rmap_status st = wait_for_ranks(context, serve, self, err);
    RMAP_TRY(st);
    /* All are done. Now each hears its last answer, before rank 0 stops to answer. */
    for (size_t i = 0; i < n; i++)
        while (is_talking(blocks[i])) {
            RMAP_TRY(rmap_blocks_serve(blocks[i], 0, blocks[i]->n_done, err));
            rmap_nap();
        }
    RMAP_TRY(wait_for_ranks(context, context->rank == 0 ? serve : NULL, self, err));
out:
    return st;
}
