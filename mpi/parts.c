/* SPDX-License-Identifier: MIT */
#include "mpi/parts.h"

#include <time.h>

#include "base/alloc.h"
#include "base/workers.h"

struct run {
    struct rmap_parts *parts;
    struct rmap_error *error; /* [n_thread] */
    _Atomic size_t next;
};

static void work(void *context, int thread)
{
    struct run *run = context;
    struct rmap_parts *parts = run->parts;
    enum rmap_status st = RMAP_OK;
    while (st == RMAP_OK && !atomic_load(&parts->abandoned)) {
        size_t first = atomic_fetch_add(&run->next, parts->step);
        if (first >= parts->last)
            return;
        size_t last = parts->last - first < parts->step ? parts->last : first + parts->step;
        st = parts->work(parts->context, thread, first, last, &run->error[thread]);
    }
    if (st != RMAP_OK)
        atomic_store(&parts->abandoned, true);
}

void rmap_parts_even(struct rmap_parts *parts, int n_thread)
{
    size_t n = parts->last - parts->first, turn = parts->step * (size_t)n_thread;
    size_t n_part = (n + turn - 1) / turn * (size_t)n_thread;
    if (n_part > 0)
        parts->step = (n + n_part - 1) / n_part;
}

static enum rmap_status wait(struct rmap_parts *parts, const struct rmap_workers *workers,
                             struct rmap_error *err)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    enum rmap_status st = RMAP_OK;
    while (parts->meanwhile && !rmap_workers_done(workers)) { /* else joining them waits */
        if (st == RMAP_OK)
            st = parts->meanwhile(parts->context, err);
        if (st != RMAP_OK)
            atomic_store(&parts->abandoned, true);
        (void)nanosleep(&millisecond, NULL);
    }
    return st;
}

enum rmap_status rmap_parts_run(struct rmap_parts *parts, int n_thread, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    struct run run = {.parts = parts, .error = rmap_alloc((size_t)n_thread, sizeof *run.error)};
    if (!run.error)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    atomic_store(&run.next, parts->first);
    atomic_store(&parts->abandoned, false);
    RMAP_TRY(rmap_workers_start(n_thread, work, &run, &workers, err));
    st = wait(parts, workers, err);
    rmap_workers_join(workers);
    for (int i = 0; i < n_thread && st == RMAP_OK; i++)
        if (run.error[i].status != RMAP_OK) {
            *err = run.error[i];
            st = err->status;
        }
out:
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
