/* SPDX-License-Identifier: MIT */
#include "mpi/copy_run.h"

#include <time.h>

#include "base/alloc.h"
#include "mpi/agree.h"
#include "mpi/parts.h"
#include "mpi/progress.h"

/* Portions that a thread takes at a time: two chunks of /ray, some dozen of /segment, so that what
 * neighbours decode twice is little and what stands out of order is little too. */
enum { PART_PORTIONS = 32 };

/* Threads wait for the disk rather than fill the memory; bytes per thread. */
static const size_t backlog_nbytes = (size_t)192 << 20;

struct copy {
    const struct rmap_context *context;
    const struct rmap_copy_plan *plan;
    struct rmap_parts parts;
    struct rmap_cursor **cursor; /* [n_thread] */
    struct rmap_progress progress;
    _Atomic uint64_t n_ray;
};

static double work_of(void *context, size_t item)
{
    const struct rmap_copy_plan *plan = ((struct copy *)context)->plan;
    const struct rmap_portion_info *info = rmap_map_portion(plan->map, plan->portion[item]);
    return (double)(info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
}

static enum rmap_status encode_chunks(struct copy *copy, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 1000000};
    struct rmap_shard_writer *writer = copy->plan->writer;
    size_t most = backlog_nbytes * (size_t)copy->context->n_thread;
    enum rmap_status st = RMAP_OK;
    for (bool did = true; did && st == RMAP_OK;)
        st = rmap_shard_writer_encode(writer, &did, err);
    while (st == RMAP_OK && !atomic_load(&copy->parts.abandoned) &&
           rmap_shard_writer_backlog(writer) > most)
        (void)nanosleep(&nap, NULL);
    return st;
}

static enum rmap_status copy_part(void *context, int thread, size_t first, size_t last,
                                  struct rmap_error *err)
{
    struct copy *copy = context;
    struct rmap_cursor **cursor = &copy->cursor[thread];
    enum rmap_status st = RMAP_OK;
    if (!*cursor)
        RMAP_TRY(rmap_cursor_create(copy->plan->map, RMAP_COLUMNS_ALL, cursor, err));
    for (size_t i = first; i < last && !atomic_load(&copy->parts.abandoned); i++) {
        const struct rmap_portion *portion = NULL;
        RMAP_TRY(rmap_cursor_read(*cursor, copy->plan->portion[i], &portion, err));
        RMAP_TRY(rmap_shard_writer_append(copy->plan->writer, portion, err));
        RMAP_TRY(encode_chunks(copy, err));
        atomic_fetch_add(&copy->n_ray, portion->n_row[RMAP_TABLE_RAY]);
    }
out:
    return st;
}

/* Rank 0 shows how far its own share has come. */
static enum rmap_status store(void *context, struct rmap_error *err)
{
    struct copy *copy = context;
    rmap_progress_show(&copy->progress, atomic_load(&copy->n_ray));
    return rmap_shard_writer_store(copy->plan->writer, err);
}

static enum rmap_status copy_share(struct copy *copy, struct rmap_error *err)
{
    const struct rmap_copy_plan *plan = copy->plan;
    enum rmap_status st = RMAP_OK;
    uint64_t n_ray = 0;
    int n_thread = copy->context->n_thread;
    copy->cursor = rmap_alloc((size_t)n_thread, sizeof *copy->cursor);
    if (!copy->cursor)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    copy->parts.context = copy;
    copy->parts.step = PART_PORTIONS;
    copy->parts.work = copy_part;
    copy->parts.meanwhile = store;
    rmap_parts_share(&copy->parts, work_of, plan->n_portion, copy->context->rank,
                     copy->context->size);
    for (size_t i = copy->parts.first; i < copy->parts.last; i++)
        n_ray += rmap_map_portion(plan->map, plan->portion[i])->n_row[RMAP_TABLE_RAY];
    rmap_progress_init(&copy->progress, copy->context, plan->what, n_ray);
    RMAP_TRY(rmap_parts_run(&copy->parts, n_thread, err));
    RMAP_TRY(rmap_shard_writer_finish(plan->writer, err));
out:
    rmap_progress_fini(&copy->progress);
    for (int i = 0; i < n_thread; i++)
        rmap_cursor_destroy(copy->cursor[i]);
    rmap_free(copy->cursor);
    return st;
}

enum rmap_status rmap_copy_run(const struct rmap_context *context,
                               const struct rmap_copy_plan *plan, struct rmap_error *err)
{
    struct copy copy = {.context = context, .plan = plan};
    enum rmap_status st = copy_share(&copy, err);
    return rmap_agree_patiently(context, st, err);
}
