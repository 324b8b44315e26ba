/* SPDX-License-Identifier: MIT
 *
 * Threads of one process that run the same function, while the caller goes on with its own work
 * (MPI, storing chunks) until they are done.
 */
#define _GNU_SOURCE /* sched_getaffinity: the cores that the launcher left to this process */
#include "base/workers.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <time.h>

#include "base/alloc.h"

struct worker {
    struct rmap_workers *all;
    pthread_t thread;
    int number;
};

struct rmap_workers {
    void (*work)(void *context, int thread);
    void *context;
    int n;
    _Atomic int running;
    struct worker *worker;
    pthread_mutex_t mutex; /* for */
    pthread_cond_t ended;  /* the last one */
};

static enum rmap_status prepare_to_wait(struct rmap_workers *workers, struct rmap_error *err)
{
    pthread_condattr_t clock;
    int failed = pthread_condattr_init(&clock);
    if (!failed)
        failed = pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    if (!failed)
        failed = pthread_mutex_init(&workers->mutex, NULL);
    if (!failed && (failed = pthread_cond_init(&workers->ended, &clock)) != 0)
        (void)pthread_mutex_destroy(&workers->mutex);
    (void)pthread_condattr_destroy(&clock);
    return failed ? rmap_error_set(err, RMAP_SYSTEM, "cannot start a thread") : RMAP_OK;
}

static void *run(void *argument)
{
    struct worker *self = argument;
    self->all->work(self->all->context, self->number);
    (void)pthread_mutex_lock(&self->all->mutex);
    if (atomic_fetch_sub(&self->all->running, 1) == 1)
        (void)pthread_cond_signal(&self->all->ended);
    (void)pthread_mutex_unlock(&self->all->mutex);
    return NULL;
}

enum rmap_status rmap_workers_start(int n, void (*work)(void *context, int thread), void *context,
                                    struct rmap_workers **workers_ret, struct rmap_error *err)
{
    struct rmap_workers *workers = rmap_alloc(1, sizeof *workers);
    struct worker *worker = rmap_alloc((size_t)n, sizeof *worker);
    enum rmap_status st = RMAP_OK;
    if (!workers || !worker)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n);
    else
        st = prepare_to_wait(workers, err);
    if (st != RMAP_OK) {
        rmap_free(workers);
        rmap_free(worker);
        return st;
    }
    workers->work = work;
    workers->context = context;
    workers->worker = worker;
    atomic_store(&workers->running, n);
    for (int i = 0; i < n; i++) {
        worker[i] = (struct worker){.all = workers, .number = i};
        if (pthread_create(&worker[i].thread, NULL, run, &worker[i]) != 0) {
            /* The threads that did start do all the work: none of it is tied to a number. */
            atomic_fetch_sub(&workers->running, n - i);
            break;
        }
        workers->n = i + 1;
    }
    if (workers->n == 0) {
        rmap_workers_join(workers);
        return rmap_error_set(err, RMAP_SYSTEM, "cannot start a thread");
    }
    *workers_ret = workers;
    return RMAP_OK;
}

bool rmap_workers_done(const struct rmap_workers *workers)
{
    return atomic_load(&workers->running) == 0;
}

bool rmap_workers_wait(struct rmap_workers *workers, int64_t most_ns)
{
    const int64_t second = 1000000000;
    struct timespec until;
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    const int64_t ns = until.tv_nsec + most_ns;
    until.tv_sec += (time_t)(ns / second);
    until.tv_nsec = (long)(ns % second);
    (void)pthread_mutex_lock(&workers->mutex);
    int failed = 0;
    while (!rmap_workers_done(workers) && !failed)
        failed = pthread_cond_timedwait(&workers->ended, &workers->mutex, &until);
    (void)pthread_mutex_unlock(&workers->mutex);
    return rmap_workers_done(workers);
}

void rmap_workers_join(struct rmap_workers *workers)
{
    if (!workers)
        return;
    for (int i = 0; i < workers->n; i++)
        (void)pthread_join(workers->worker[i].thread, NULL);
    (void)pthread_cond_destroy(&workers->ended);
    (void)pthread_mutex_destroy(&workers->mutex);
    rmap_free(workers->worker);
    rmap_free(workers);
}

static void pass_gate(void *gate, int thread)
{
    (void)thread;
    (void)pthread_mutex_lock(gate);
    (void)pthread_mutex_unlock(gate);
}

bool rmap_workers_can_start(int n)
{
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    struct rmap_workers *workers = NULL;
    (void)pthread_mutex_lock(&gate);
    const bool all =
        rmap_workers_start(n, pass_gate, &gate, &workers, NULL) == RMAP_OK && workers->n == n;
    (void)pthread_mutex_unlock(&gate);
    rmap_workers_join(workers);
    (void)pthread_mutex_destroy(&gate);
    return all;
}

int rmap_workers_available(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    int n = CPU_COUNT(&set);
    return n > 0 ? n : 1;
}
