/* SPDX-License-Identifier: MIT
 *
 * Portions of an open map written again into shards, on all ranks and threads: what `convert` does
 * with a whole map and `repair` with what is left of a damaged piece.
 */
#include "mpi/scan/copy_run.h"

#include "base/alloc.h"
#include "io/map/map_cursor.h"
#include "io/map/map_run.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_content.h"
#include "mpi/parallel/nap.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"

/* Portions that a thread takes at a time: two chunks of /ray, some dozen of /segment, so that what
 * neighbours decode twice is little and what stands out of order is little too. */
enum { PART_PORTIONS = 32 };

/* Threads wait for the disk rather than fill the memory; bytes per thread. */
static const size_t backlog_nbytes = (size_t)192 << 20;

/* Portions of one colour space and encoding, and the writer that takes them. */
struct copy {
    const struct rmap_context *context;
    const struct rmap_copy_plan *plan;
    size_t *portion; /* of the map, ascending [n_portion]; the same on every rank */
    size_t n_portion;
    struct rmap_map_run run;
    struct rmap_shard_writer *writer;
    struct rmap_parts parts;
    struct rmap_cursor **cursor; /* [n_thread] */
    struct rmap_progress progress;
    _Atomic uint64_t n_ray;
};

static double work_of(void *context, size_t item)
{
    const struct copy *copy = context;
    const struct rmap_portion_info *info = rmap_map_portion(copy->plan->map, copy->portion[item]);
    return (double)(info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
}

static enum rmap_status encode_chunks(struct copy *copy, struct rmap_error *err)
{
    struct rmap_shard_writer *writer = copy->writer;
    size_t most = backlog_nbytes * (size_t)copy->context->n_thread;
    enum rmap_status st = RMAP_OK;
    for (bool did = true; did && st == RMAP_OK;)
        st = rmap_shard_writer_encode(writer, &did, err);
    while (st == RMAP_OK && !atomic_load(&copy->parts.abandoned) &&
           rmap_shard_writer_backlog(writer) > most)
        rmap_nap();
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
        RMAP_TRY(rmap_cursor_read(*cursor, copy->portion[i], &portion, err));
        RMAP_TRY(rmap_shard_writer_append(copy->writer, portion, err));
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
    return rmap_shard_writer_store(copy->writer, err);
}

static enum rmap_status copy_share(struct copy *copy, struct rmap_error *err)
{
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
    rmap_parts_share(&copy->parts, work_of, copy->n_portion, copy->context->rank,
                     copy->context->size);
    for (size_t i = copy->parts.first; i < copy->parts.last; i++)
        n_ray += rmap_map_portion(copy->plan->map, copy->portion[i])->n_row[RMAP_TABLE_RAY];
    rmap_progress_init(&copy->progress, copy->context, "rays", n_ray);
    RMAP_TRY(rmap_parts_run(&copy->parts, n_thread, err));
    RMAP_TRY(rmap_shard_writer_finish(copy->writer, err));
out:
    rmap_progress_fini(&copy->progress);
    for (int i = 0; i < n_thread; i++)
        rmap_cursor_destroy(copy->cursor[i]);
    rmap_free(copy->cursor);
    return st;
}

static enum rmap_status prepare(struct copy *copy, size_t space, enum rmap_encoding encoding,
                                struct rmap_error *err)
{
    const struct rmap_copy_plan *plan = copy->plan;
    enum rmap_status st = RMAP_OK;
    /* A copy that is killed is begun again: nothing is flushed, and equal work gives equal bytes.
     */
    const struct rmap_shard_options options = {.piece_nbytes = plan->piece_nbytes};
    RMAP_TRY(rmap_map_run_init(plan->map, space, encoding, &copy->run, err));
    RMAP_TRY(rmap_shard_writer_create(plan->to, plan->shard + copy->context->rank, &copy->run.run,
                                      &options, &copy->writer, err));
out:
    return st;
}

/* What encoding a portion is written in. */
static enum rmap_encoding encoding_of(const struct rmap_copy_plan *plan,
                                      const struct rmap_portion_info *info)
{
    if (plan->encoding != RMAP_ENCODING_COUNT)
        return plan->encoding;
    return (enum rmap_encoding)rmap_map_piece(plan->map, (size_t)info->piece)->encoding;
}

/* Collective. */
static enum rmap_status copy_kind(const struct rmap_context *context,
                                  const struct rmap_copy_plan *plan, size_t space,
                                  enum rmap_encoding encoding, struct rmap_map_content *content,
                                  struct rmap_error *err)
{
    struct copy copy = {.context = context, .plan = plan};
    enum rmap_status st = RMAP_OK;
    size_t n = rmap_map_n_portion(plan->map);
    copy.portion = rmap_alloc(n, sizeof *copy.portion);
    if (!copy.portion)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t i = 0; i < n; i++) {
        const struct rmap_portion_info *info = rmap_map_portion(plan->map, i);
        if ((size_t)info->space == space && encoding_of(plan, info) == encoding &&
            !(plan->skip && plan->skip[i]))
            copy.portion[copy.n_portion++] = i;
    }
    if (copy.n_portion == 0)
        goto out;
    st = prepare(&copy, space, encoding, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = copy_share(&copy, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(rmap_gather_content(context, rmap_shard_writer_content(copy.writer), content, err));
out:
    rmap_shard_writer_destroy(copy.writer);
    rmap_map_run_fini(&copy.run);
    rmap_free(copy.portion);
    return st;
}

enum rmap_status rmap_copy_run(const struct rmap_context *context,
                               const struct rmap_copy_plan *plan, struct rmap_map_content *content,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t space = 0; space < rmap_map_n_space(plan->map) && st == RMAP_OK; space++)
        for (int e = 0; e < RMAP_ENCODING_COUNT && st == RMAP_OK; e++)
            st = copy_kind(context, plan, space, (enum rmap_encoding)e, content, err);
    return st;
}
