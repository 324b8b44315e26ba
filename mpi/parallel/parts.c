/* SPDX-License-Identifier: MIT
 *
 * Many like items done by the threads of a rank, while the calling thread shows progress and does
 * what it alone may do.
 */
#include "mpi/parallel/parts.h"

#include <pthread.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/parallel/interrupt.h"

/* Items that a thread has not begun yet. */
struct stretch {
    size_t next, end;
};

struct run {
    struct rmap_parts *parts;
    struct rmap_error *error; /* [n_thread] */
    int n_thread;
    pthread_mutex_t mutex;
    struct stretch *stretch; /* [n_thread], under the mutex; IN_ORDER: one, of all threads */
};

static struct stretch *longest_of(struct stretch *stretch, int n)
{
    struct stretch *longest = stretch;
    for (int i = 1; i < n; i++)
        if (stretch[i].end - stretch[i].next > longest->end - longest->next)
            longest = &stretch[i];
    return longest;
}

/* The next items of a thread, [first, last): none when all have been begun. */
static void take(struct run *run, int thread, size_t *first, size_t *last)
{
    bool near = run->parts->order == RMAP_PARTS_NEAR;
    struct stretch *own = &run->stretch[near ? thread : 0];
    (void)pthread_mutex_lock(&run->mutex);
    if (near && own->next == own->end) {
        struct stretch *other = longest_of(run->stretch, run->n_thread);
        size_t middle = other->next + (other->end - other->next) / 2;
        *own = (struct stretch){middle, other->end};
        other->end = middle;
    }
    size_t left = own->end - own->next;
    *first = own->next;
    *last = own->next += left < run->parts->step ? left : run->parts->step;
    (void)pthread_mutex_unlock(&run->mutex);
}

static void work(void *context, int thread)
{
    struct run *run = context;
    struct rmap_parts *parts = run->parts;
    enum rmap_status st = RMAP_OK;
    while (st == RMAP_OK && !atomic_load(&parts->abandoned)) {
        size_t first, last;
        take(run, thread, &first, &last);
        if (first == last)
            return;
        if (rmap_interrupt_stops_question())
            st = rmap_error_set(&run->error[thread], RMAP_INPUT, "stopped");
        else
            st = parts->work(parts->context, thread, first, last, &run->error[thread]);
    }
    if (st != RMAP_OK)
        atomic_store(&parts->abandoned, true);
}

static void share_out(struct run *run)
{
    const struct rmap_parts *parts = run->parts;
    size_t n = parts->order == RMAP_PARTS_NEAR ? (size_t)run->n_thread : 1;
    size_t n_item = parts->last - parts->first, begun = parts->first;
    for (size_t i = 0; i < n; i++) {
        size_t end = parts->first + n_item / n * (i + 1) + n_item % n * (i + 1) / n;
        run->stretch[i] = (struct stretch){begun, end};
        begun = end;
    }
}

static enum rmap_status wait(struct rmap_parts *parts, struct rmap_workers *workers,
                             struct rmap_error *err)
{
    const int64_t millisecond = 1000000;
    enum rmap_status st = RMAP_OK;
    while (!rmap_workers_done(workers)) {
        if (st == RMAP_OK)
            st = parts->meanwhile(parts->context, err);
        if (st != RMAP_OK)
            atomic_store(&parts->abandoned, true);
        (void)rmap_workers_wait(workers, millisecond);
    }
    return st;
}

enum rmap_status rmap_parts_run(struct rmap_parts *parts, int n_thread, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    struct run run = {.parts = parts,
                      .n_thread = n_thread,
                      .error = rmap_alloc((size_t)n_thread, sizeof *run.error),
                      .stretch = rmap_alloc((size_t)n_thread, sizeof *run.stretch)};
    (void)pthread_mutex_init(&run.mutex, NULL);
    if (!run.error || !run.stretch)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread));
    share_out(&run);
    atomic_store(&parts->abandoned, false);
    const int n_more = parts->meanwhile ? n_thread : n_thread - 1;
    if (n_more > 0)
        RMAP_TRY(rmap_workers_start(n_more, work, &run, &workers, err));
    if (parts->meanwhile)
        st = wait(parts, workers, err);
    else
        work(&run, n_more); /* this thread has nothing else to do */
    rmap_workers_join(workers);
    for (int i = 0; i < n_thread && st == RMAP_OK; i++)
        if (run.error[i].status != RMAP_OK) {
            *err = run.error[i];
            st = err->status;
        }
out:
    (void)pthread_mutex_destroy(&run.mutex);
    rmap_free(run.stretch);
    rmap_free(run.error);
    return st;
}

void rmap_parts_share(struct rmap_parts *parts, double (*work_of)(void *context, size_t item),
                      size_t n, int rank, int size)
{
    double total = 0.0, before = 0.0;
    for (size_t i = 0; i < n; i++)
        total += work_of(parts->context, i);
    parts->first = parts->last = 0;
    for (size_t i = 0; i < n; i++) {
        parts->first += before * size < total * rank;
        parts->last += rank == size - 1 || before * size < total * (rank + 1);
        before += work_of(parts->context, i);
    }
}
