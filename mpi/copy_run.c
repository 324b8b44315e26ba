/* SPDX-License-Identifier: MIT */
#include "mpi/copy_run.h"

#include <stdatomic.h>
#include <time.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/agree.h"
#include "mpi/progress.h"

/* Portions that a thread takes at a time: two chunks of /ray, some dozen of /segment, so that what
 * neighbours decode twice is little and what stands out of order is little too. */
enum { PART_PORTIONS = 32 };

/* Threads wait for the disk rather than fill the memory; bytes per thread. */
static const size_t backlog_nbytes = (size_t)192 << 20;

struct copy {
    const struct rmap_context *context;
    const struct rmap_copy_plan *plan;
    size_t first, last;       /* this rank's, in plan->portion */
    struct rmap_error *error; /* [n_thread] */
    _Atomic size_t next;
    _Atomic uint64_t n_ray;
    _Atomic bool abandoned;
};

static void nap(void)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    (void)nanosleep(&millisecond, NULL);
}

static uint64_t work_of(const struct rmap_copy_plan *plan, size_t i)
{
    const struct rmap_portion_info *info = rmap_map_portion(plan->map, plan->portion[i]);
    return info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT];
}

/* Contiguous shares of about the same work: a portion belongs where it begins. */
static void share_out(struct copy *copy)
{
    const struct rmap_copy_plan *plan = copy->plan;
    double total = 0.0, before = 0.0, size = copy->context->size, rank = copy->context->rank;
    for (size_t i = 0; i < plan->n_portion; i++)
        total += (double)work_of(plan, i);
    copy->first = copy->last = 0;
    for (size_t i = 0; i < plan->n_portion; i++) {
        copy->first += before * size < total * rank;
        copy->last += before * size < total * (rank + 1.0);
        before += (double)work_of(plan, i);
    }
}

static enum rmap_status encode_chunks(struct copy *copy, struct rmap_error *err)
{
    struct rmap_shard_writer *writer = copy->plan->writer;
    size_t most = backlog_nbytes * (size_t)copy->context->n_thread;
    enum rmap_status st = RMAP_OK;
    for (bool did = true; did && st == RMAP_OK;)
        st = rmap_shard_writer_encode(writer, &did, err);
    while (st == RMAP_OK && !atomic_load(&copy->abandoned) &&
           rmap_shard_writer_backlog(writer) > most)
        nap();
    return st;
}

static enum rmap_status copy_part(struct copy *copy, struct rmap_cursor *cursor, size_t first,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t last = copy->last - first < PART_PORTIONS ? copy->last : first + PART_PORTIONS;
    for (size_t i = first; i < last && !atomic_load(&copy->abandoned); i++) {
        const struct rmap_portion *portion = NULL;
        RMAP_TRY(rmap_cursor_read(cursor, copy->plan->portion[i], &portion, err));
        RMAP_TRY(rmap_shard_writer_append(copy->plan->writer, portion, err));
        RMAP_TRY(encode_chunks(copy, err));
        atomic_fetch_add(&copy->n_ray, portion->n_row[RMAP_TABLE_RAY]);
    }
out:
    return st;
}

static void copy_parts(void *context, int thread)
{
    struct copy *copy = context;
    struct rmap_error *err = &copy->error[thread];
    struct rmap_cursor *cursor = NULL;
    enum rmap_status st = rmap_cursor_create(copy->plan->map, RMAP_COLUMNS_ALL, &cursor, err);
    while (st == RMAP_OK && !atomic_load(&copy->abandoned)) {
        size_t first = atomic_fetch_add(&copy->next, PART_PORTIONS);
        if (first >= copy->last)
            break;
        st = copy_part(copy, cursor, first, err);
    }
    rmap_cursor_destroy(cursor);
    if (st != RMAP_OK)
        atomic_store(&copy->abandoned, true);
}

static uint64_t rays_of_share(const struct copy *copy)
{
    uint64_t n = 0;
    for (size_t i = copy->first; i < copy->last; i++)
        n += rmap_map_portion(copy->plan->map, copy->plan->portion[i])->n_row[RMAP_TABLE_RAY];
    return n;
}

/* What the calling thread does meanwhile. Rank 0 shows how far its own share has come. */
static enum rmap_status serve(struct copy *copy, struct rmap_workers *workers,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_progress progress;
    rmap_progress_init(&progress, copy->context, copy->plan->what, rays_of_share(copy));
    while (!rmap_workers_done(workers)) {
        if (st == RMAP_OK)
            st = rmap_shard_writer_store(copy->plan->writer, err);
        if (st != RMAP_OK)
            atomic_store(&copy->abandoned, true);
        rmap_progress_show(&progress, atomic_load(&copy->n_ray));
        nap();
    }
    rmap_progress_fini(&progress);
    return st;
}

static enum rmap_status copy_share(struct copy *copy, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    int n_thread = copy->context->n_thread;
    copy->error = rmap_alloc((size_t)n_thread, sizeof *copy->error);
    if (!copy->error)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    share_out(copy);
    atomic_store(&copy->next, copy->first);
    RMAP_TRY(rmap_workers_start(n_thread, copy_parts, copy, &workers, err));
    st = serve(copy, workers, err);
    rmap_workers_join(workers);
    for (int i = 0; i < n_thread && st == RMAP_OK; i++)
        if (copy->error[i].status != RMAP_OK) {
            *err = copy->error[i];
            st = err->status;
        }
    RMAP_TRY(st);
    RMAP_TRY(rmap_shard_writer_finish(copy->plan->writer, err));
out:
    rmap_free(copy->error);
    return st;
}

enum rmap_status rmap_copy_run(const struct rmap_context *context,
                               const struct rmap_copy_plan *plan, struct rmap_error *err)
{
    struct copy copy = {.context = context, .plan = plan};
    enum rmap_status st = copy_share(&copy, err);
    return rmap_agree_patiently(context, st, err);
}
