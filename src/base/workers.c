/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* sched_getaffinity: the cores that the launcher left to this process */
#include "base/workers.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

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
};

static void *run(void *argument)
{
    struct worker *self = argument;
    self->all->work(self->all->context, self->number);
    atomic_fetch_sub(&self->all->running, 1);
    return NULL;
}

enum rmap_status rmap_workers_start(int n, void (*work)(void *context, int thread), void *context,
                                    struct rmap_workers **workers_ret, struct rmap_error *err)
{
    struct rmap_workers *workers = rmap_alloc(1, sizeof *workers);
    struct worker *worker = rmap_alloc((size_t)n, sizeof *worker);
    if (!workers || !worker) {
        rmap_free(workers);
        rmap_free(worker);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n);
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

void rmap_workers_join(struct rmap_workers *workers)
{
    if (!workers)
        return;
    for (int i = 0; i < workers->n; i++)
        (void)pthread_join(workers->worker[i].thread, NULL);
    rmap_free(workers->worker);
    rmap_free(workers);
}

int rmap_workers_available(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    int n = CPU_COUNT(&set);
    return n > 0 ? n : 1;
}
