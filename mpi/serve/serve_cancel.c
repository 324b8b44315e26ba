/* SPDX-License-Identifier: MIT
 *
 * A request that is cancelled on rank 0 stops on all ranks: a thread of each hears of it, whatever
 * its main thread computes or waits for.
 */
#include "mpi/serve/serve_cancel.h"

#include <pthread.h>
#include <time.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"

enum { TAG_CANCEL = 82 };
static const uint64_t over = UINT64_MAX; /* a number that no request has */

struct rmap_serve_cancel {
    MPI_Comm comm; /* of the threads alone */
    int rank, size;
    pthread_t thread;
    bool runs;
    pthread_mutex_t lock; /* of all below */
    uint64_t number;      /* of the request in hand or the last one, from 1 */
    uint64_t cancelled;   /* the last that was; over: the server ends */
    bool inside;          /* a request is in hand */
};

static void rest(void)
{
    const struct timespec some = {.tv_nsec = 10000000};
    (void)nanosleep(&some, NULL);
}

/* Rank 0's. MPI's errors are met by the main thread, too, and reported there. */
static void *tell(void *argument)
{
    struct rmap_serve_cancel *self = argument;
    uint64_t told = 0;
    while (told != over) {
        (void)pthread_mutex_lock(&self->lock);
        if (self->inside && rmap_interrupt_stops_question() && self->cancelled != over)
            self->cancelled = self->number;
        const uint64_t word = self->cancelled;
        (void)pthread_mutex_unlock(&self->lock);
        for (int r = 1; r < self->size && word != told; r++)
            (void)MPI_Send(&word, 1, MPI_UINT64_T, r, TAG_CANCEL, self->comm);
        told = word;
        if (told != over)
            rest();
    }
    return NULL;
}

/* With the lock. It may be heard before the request is, or when another one is in hand. */
static void obey(const struct rmap_serve_cancel *self)
{
    if (self->inside && self->cancelled == self->number)
        rmap_interrupt_stop_question();
}

static void *listen(void *argument)
{
    struct rmap_serve_cancel *self = argument;
    uint64_t word = 0;
    while (word != over) {
        MPI_Request request;
        int came = 0;
        if (MPI_Irecv(&word, 1, MPI_UINT64_T, 0, TAG_CANCEL, self->comm, &request) != MPI_SUCCESS)
            break;
        while (MPI_Test(&request, &came, MPI_STATUS_IGNORE) == MPI_SUCCESS && !came)
            rest();
        if (!came)
            break;
        (void)pthread_mutex_lock(&self->lock);
        self->cancelled = word;
        obey(self);
        (void)pthread_mutex_unlock(&self->lock);
    }
    return NULL;
}

static void *(*work_of(const struct rmap_serve_cancel *self))(void *)
{
    return self->rank == 0 ? tell : listen;
}

enum rmap_status rmap_serve_cancel_start(const struct rmap_context *context,
                                         struct rmap_serve_cancel **cancel_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *cancel_ret = NULL;
    if (!context->watchdog)
        return RMAP_OK;
    struct rmap_serve_cancel *self = rmap_alloc(1, sizeof *self);
    if (!self)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a server");
    RMAP_TRY(rmap_agree(context, st, err));
    *self = (struct rmap_serve_cancel){.rank = context->rank, .size = context->size};
    (void)pthread_mutex_init(&self->lock, NULL);
    RMAP_TRY(RMAP_MPI(MPI_Comm_dup(context->comm, &self->comm)));
    self->runs = pthread_create(&self->thread, NULL, work_of(self), self) == 0;
    if (!self->runs)
        st = rmap_error_set(err, RMAP_SYSTEM, "rank %d: no thread can be started", self->rank);
    st = rmap_agree(context, st, err);
    if (st == RMAP_OK)
        *cancel_ret = self;
    else
        rmap_serve_cancel_finish(self);
    return st;
out:
    rmap_free(self);
    return st;
}

void rmap_serve_cancel_finish(struct rmap_serve_cancel *self)
{
    if (!self)
        return;
    (void)pthread_mutex_lock(&self->lock);
    if (self->rank == 0)
        self->cancelled = over;
    (void)pthread_mutex_unlock(&self->lock);
    if (self->runs)
        (void)pthread_join(self->thread, NULL);
    else
        (void)work_of(self)(self); /* others wait for the word */
    (void)MPI_Comm_free(&self->comm);
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self);
}

void rmap_serve_cancel_begin(struct rmap_serve_cancel *self)
{
    if (!self)
        return;
    (void)pthread_mutex_lock(&self->lock);
    self->number++;
    self->inside = true;
    obey(self);
    (void)pthread_mutex_unlock(&self->lock);
}

void rmap_serve_cancel_end(struct rmap_serve_cancel *self)
{
    if (!self)
        return;
    (void)pthread_mutex_lock(&self->lock);
    self->inside = false;
    if (self->rank != 0) /* rank 0's may be of the next one already */
        rmap_interrupt_forget();
    (void)pthread_mutex_unlock(&self->lock);
}
