/* SPDX-License-Identifier: MIT
 *
 * The worker threads of one rank while it traces.
 */
#include "mpi/trace/trace_workers.h"

#include <stdatomic.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "io/map/map_cursor.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "mpi/parallel/nap.h"
#include "mpi/parallel/progress.h"
#include "portion/portion_recorder.h"
#include "trace/tracer.h"

/* Workers wait rather than run ahead of the disk by more than this per thread. */
static const size_t backlog_nbytes = (size_t)192 << 20;

struct worker {
    struct rmap_portion *portion;   /* NULL when nothing is recorded */
    struct rmap_shard_block *parts; /* NULL: blocks are kept whole */
    unsigned n_whole;               /* blocks that are, next */
    struct rmap_tally *tally;
    struct rmap_cursor *cursor; /* of the map whose portions are summed up again */
    struct rmap_error error;
    struct rmap_reuse_reader *reader; /* NULL: every ray is traced */
    _Atomic uint64_t n_ray;           /* traced */
    uint64_t n_reused;                /* of them, taken over */
};

struct rmap_trace_workers {
    const struct rmap_trace_plan *plan;
    const struct rmap_ray_plan *rays;
    struct rmap_block_queue *queue;
    struct rmap_workers *threads;
    int n_thread;
    struct worker *worker;                /* [n_thread] */
    _Atomic bool failed, abandoned, left; /* left: rays that are not begun are not traced */
    _Atomic uint64_t block_ns;
};

/* A block goes to this rank's shard, or to the rank that writes for this one. */
static enum rmap_status keep_block(struct rmap_trace_workers *all, struct worker *self)
{
    struct rmap_message *message = NULL;
    if (all->plan->writer)
        return rmap_shard_writer_append(all->plan->writer, self->portion, &self->error);
    enum rmap_status st =
        rmap_message_pack(self->portion, RMAP_COLUMNS_ALL, &message, &self->error);
    while (st == RMAP_OK && rmap_forward_full(all->plan->forward) && !atomic_load(&all->abandoned))
        rmap_nap();
    return st == RMAP_OK ? rmap_forward_put(all->plan->forward, message, &self->error) : st;
}

/* A block in hand. It stays where it is: its recorders know each other. */
struct block {
    struct rmap_trace_workers *all;
    struct worker *self;
    struct rmap_tracer tracer;
    struct rmap_ray_range rays;
    uint64_t end;                         /* the first ray that is not traced yet */
    uint64_t n_before;                    /* rays that this worker traced in other blocks */
    struct rmap_portion_recorder history; /* where anything is recorded */
    struct rmap_tally_recorder recorder;  /* of the sums, and by `history` */
};

static void begin_block(struct block *block, struct rmap_trace_workers *all, struct worker *self,
                        struct rmap_ray_range rays)
{
    const struct rmap_trace_plan *plan = all->plan;
    block->all = all;
    block->self = self;
    block->tracer = (struct rmap_tracer){plan->scene, plan->accel, plan->seed};
    block->rays = rays;
    block->end = rays.first;
    block->n_before = atomic_load(&self->n_ray);
    block->history.status = RMAP_OK;
    if (self->portion) {
        rmap_portion_recorder_init(&block->history, self->portion);
        rmap_portion_recorder_restart(&block->history, rays.first);
        block->history.unpredicted.seed = plan->seed;
    }
    rmap_tally_recorder_init(&block->recorder, self->tally,
                             self->portion ? &block->history.base : NULL);
}

/* The ray `id`, or it and those behind it, before `end`, that an older map has; *n_ret: how many.
 */
static enum rmap_status record_next(struct block *block, uint64_t id, uint64_t end,
                                    struct rmap_recorder *recorder, struct rmap_tally *tally,
                                    uint64_t *n_ret)
{
    struct worker *self = block->self;
    enum rmap_status st = RMAP_OK;
    struct rmap_known_way way;
    RMAP_TRY(rmap_reuse_ready(self->reader, id, end, n_ret, &way, &self->error));
    if (*n_ret > 0)
        return rmap_reuse_take(self->reader, *n_ret, &block->history, tally, &self->error);
    rmap_trace_known(&block->tracer, id, &way, recorder);
out:
    return st;
}

static enum rmap_status trace_up_to(struct block *block, uint64_t end)
{
    const struct rmap_trace_workers *all = block->all;
    struct worker *self = block->self;
    while (block->end < end && !atomic_load_explicit(&all->left, memory_order_relaxed)) {
        uint64_t n;
        enum rmap_status st =
            record_next(block, block->end, end, &block->recorder.base, self->tally, &n);
        if (st != RMAP_OK)
            return st;
        self->n_reused += n;
        block->end += n > 0 ? n : 1;
        atomic_store_explicit(&self->n_ray, block->n_before + block->end - block->rays.first,
                              memory_order_relaxed);
    }
    return RMAP_OK;
}

static enum rmap_status check_history(struct block *block, uint64_t first)
{
    if (block->history.status == RMAP_OK && block->recorder.status == RMAP_OK)
        return RMAP_OK;
    return rmap_error_set(&block->self->error, RMAP_SYSTEM,
                          "out of memory for the histories of rays %llu to %llu",
                          (unsigned long long)first, (unsigned long long)(block->end - 1));
}

/* Each part is kept before the next is traced. *whole_ret: those up to the block's `end` have to be
 * kept in one, and are not kept. */
static enum rmap_status trace_parts(struct block *block, bool *whole_ret)
{
    struct worker *self = block->self;
    enum rmap_status st = RMAP_OK;
    uint64_t end;
    do {
        const uint64_t first = block->end, left = block->rays.end - first;
        end = first + (left < RMAP_PART_RAYS ? left : RMAP_PART_RAYS);
        rmap_portion_recorder_restart(&block->history, first);
        RMAP_TRY(trace_up_to(block, end));
        RMAP_TRY(check_history(block, first));
        RMAP_TRY(rmap_shard_block_add(self->parts, self->portion, whole_ret, &self->error));
    } while (block->end == end && end < block->rays.end && !*whole_ret);
    if (!*whole_ret)
        RMAP_TRY(rmap_shard_block_append(self->parts, whole_ret, &self->error));
out:
    return st;
}

/* Records once more what was traced, whose sums are there. */
static enum rmap_status record_again(struct block *block)
{
    enum rmap_status st = RMAP_OK;
    rmap_portion_recorder_restart(&block->history, block->rays.first);
    for (uint64_t id = block->rays.first, n; id < block->end && st == RMAP_OK; id += n > 0 ? n : 1)
        st = record_next(block, id, block->end, &block->history.base, NULL, &n);
    return st;
}

/* Where parts did not do, they will not for some time. */
#define WHOLE_BLOCKS 64

static enum rmap_status trace_block(struct rmap_trace_workers *all, struct worker *self,
                                    struct rmap_ray_range rays)
{
    enum rmap_status st = RMAP_OK;
    struct block block;
    begin_block(&block, all, self, rays);
    if (self->parts && self->n_whole == 0) {
        bool whole = false;
        RMAP_TRY(trace_parts(&block, &whole));
        if (!whole)
            goto out;
        self->n_whole = WHOLE_BLOCKS;
        RMAP_TRY(record_again(&block));
    }
    self->n_whole -= self->n_whole > 0;
    RMAP_TRY(trace_up_to(&block, rays.end));
    if (block.end > rays.first)
        RMAP_TRY(check_history(&block, rays.first));
    if (self->portion && block.end > rays.first)
        RMAP_TRY(keep_block(all, self));
out:
    rmap_tally_recorder_fini(&block.recorder);
    if (self->portion)
        self->portion->unpredicted = NULL;
    return st;
}

/* A block that another rank traced, into this rank's shard. */
static enum rmap_status store_message(struct rmap_trace_workers *all, struct worker *self,
                                      const struct rmap_message *message)
{
    struct rmap_portion view;
    enum rmap_status st = rmap_message_view(message, &view, &self->error);
    if (st == RMAP_OK)
        st = rmap_shard_writer_append(all->plan->writer, &view, &self->error);
    return st;
}

/* A part of the portions whose sums nobody kept. */
static enum rmap_status recount(struct rmap_trace_workers *all, struct worker *self, uint64_t part)
{
    const struct rmap_trace_recount *list = &all->plan->recount;
    const struct rmap_portion *portion = NULL;
    enum rmap_status st = RMAP_OK;
    size_t first = (size_t)part * RMAP_PART_PORTIONS;
    size_t n = list->n - first < RMAP_PART_PORTIONS ? list->n - first : RMAP_PART_PORTIONS;
    if (!self->cursor)
        RMAP_TRY(rmap_cursor_create(list->map, RMAP_TALLY_COLUMNS, &self->cursor, &self->error));
    for (size_t i = first; i < first + n && !atomic_load(&all->abandoned); i++) {
        RMAP_TRY(rmap_cursor_read(self->cursor, list->portion[i], &portion, &self->error));
        RMAP_TRY(rmap_tally_add_portion(self->tally, portion, &self->error));
    }
out:
    return st;
}

/* Full chunks are encoded as soon as they are there, by whoever is free; when the disk is the
 * slow one, everyone waits for it. */
static enum rmap_status encode_chunks(struct rmap_trace_workers *all, struct worker *self)
{
    struct rmap_shard_writer *writer = all->plan->writer;
    enum rmap_status st = RMAP_OK;
    bool did = writer != NULL;
    while (did && st == RMAP_OK)
        st = rmap_shard_writer_encode(writer, &did, &self->error);
    while (writer && st == RMAP_OK && !atomic_load(&all->abandoned) &&
           rmap_shard_writer_backlog(writer) > backlog_nbytes * (size_t)all->n_thread)
        rmap_nap();
    return st;
}

static enum rmap_status do_item(struct rmap_trace_workers *all, struct worker *self,
                                const struct rmap_work_item *item)
{
    double begun = rmap_clock_seconds();
    enum rmap_status st = RMAP_OK;
    switch (item->work) {
    case RMAP_WORK_RECOUNT:
        return recount(all, self, item->number);
    case RMAP_WORK_STORE:
        st = store_message(all, self, item->message);
        return st == RMAP_OK ? encode_chunks(all, self) : st;
    case RMAP_WORK_TRACE:
        break;
    }
    st = trace_block(all, self, rmap_ray_plan_block(all->rays, item->number));
    if (st == RMAP_OK)
        st = encode_chunks(all, self);
    atomic_store(&all->block_ns, (uint64_t)(1e9 * (rmap_clock_seconds() - begun)) + 1);
    return st;
}

static void work(void *context, int thread)
{
    struct rmap_trace_workers *all = context;
    struct worker *self = &all->worker[thread];
    enum rmap_status st = RMAP_OK;
    struct rmap_work_item item;
    while (st == RMAP_OK && !atomic_load(&all->abandoned) &&
           rmap_block_queue_pop(all->queue, &item)) {
        st = do_item(all, self, &item);
        rmap_message_destroy(item.message);
    }
    if (st != RMAP_OK)
        atomic_store(&all->failed, true);
    rmap_block_queue_knock(all->queue);
}

enum rmap_status rmap_trace_workers_start(const struct rmap_trace_plan *plan,
                                          const struct rmap_ray_plan *rays, int n_thread,
                                          struct rmap_block_queue *queue,
                                          struct rmap_trace_workers **workers_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_trace_workers *workers = rmap_alloc(1, sizeof *workers);
    if (!workers)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    workers->plan = plan;
    workers->rays = rays;
    workers->queue = queue;
    workers->n_thread = n_thread;
    workers->worker = rmap_alloc((size_t)n_thread, sizeof *workers->worker);
    if (!workers->worker)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread));
    for (int i = 0; i < n_thread; i++) {
        RMAP_TRY(rmap_tally_create(plan->scene, &workers->worker[i].tally, err));
        if (plan->writer || plan->forward)
            RMAP_TRY(rmap_portion_create(RMAP_BLOCK_RAYS, plan->scene->channels.n,
                                         &workers->worker[i].portion, err));
        if (workers->worker[i].portion)
            RMAP_TRY(rmap_portion_set_timed(workers->worker[i].portion, plan->scene->timed, err));
        if (plan->writer)
            RMAP_TRY(rmap_shard_block_create(plan->writer, &workers->worker[i].parts, err));
        if (plan->reuse && workers->worker[i].portion)
            RMAP_TRY(rmap_reuse_reader_create(plan->reuse, &workers->worker[i].reader, err));
    }
    RMAP_TRY(rmap_workers_start(n_thread, work, workers, &workers->threads, err));
    *workers_ret = workers;
    workers = NULL;
out:
    rmap_trace_workers_destroy(workers);
    return st;
}

bool rmap_trace_workers_done(const struct rmap_trace_workers *workers)
{
    return rmap_workers_done(workers->threads);
}

bool rmap_trace_workers_failed(const struct rmap_trace_workers *workers)
{
    return atomic_load(&workers->failed);
}

void rmap_trace_workers_abandon(struct rmap_trace_workers *workers)
{
    atomic_store(&workers->abandoned, true);
}

void rmap_trace_workers_leave(struct rmap_trace_workers *workers)
{
    atomic_store(&workers->left, true);
}

uint64_t rmap_trace_workers_traced(const struct rmap_trace_workers *workers)
{
    uint64_t n = 0;
    for (int i = 0; i < workers->n_thread; i++)
        n += atomic_load_explicit(&workers->worker[i].n_ray, memory_order_relaxed);
    return n;
}

uint64_t rmap_trace_workers_reused(const struct rmap_trace_workers *workers)
{
    uint64_t n = 0;
    for (int i = 0; i < workers->n_thread; i++)
        n += workers->worker[i].n_reused;
    return n;
}

double rmap_trace_workers_pace(const struct rmap_trace_workers *workers)
{
    return 1e-9 * (double)atomic_load(&workers->block_ns);
}

enum rmap_status rmap_trace_workers_join(struct rmap_trace_workers *workers,
                                         struct rmap_tally **tally_ret, uint64_t *n_ray_ret,
                                         struct rmap_error *err)
{
    rmap_workers_join(workers->threads);
    workers->threads = NULL;
    *n_ray_ret = rmap_trace_workers_traced(workers);
    for (int i = 0; i < workers->n_thread; i++) {
        struct worker *worker = &workers->worker[i];
        if (worker->error.status != RMAP_OK) {
            *err = worker->error;
            return err->status;
        }
        if (i > 0)
            rmap_tally_merge(workers->worker[0].tally, worker->tally);
    }
    *tally_ret = workers->worker[0].tally;
    workers->worker[0].tally = NULL;
    return RMAP_OK;
}

static enum rmap_status encode_all(struct rmap_shard_writer *writer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool did = true;
    while (did && st == RMAP_OK)
        st = rmap_shard_writer_encode(writer, &did, err);
    return st;
}

/* A shard that failed in one of these tells so to the thread that finishes it. */
static void help_to_encode(void *context, int thread)
{
    struct rmap_error error;
    (void)thread;
    (void)encode_all(context, &error);
}

enum rmap_status rmap_trace_encode_rest(struct rmap_shard_writer *writer, int n_thread,
                                        struct rmap_error *err)
{
    struct rmap_workers *helpers = NULL;
    struct rmap_error alone;
    enum rmap_status st = rmap_shard_writer_end(writer, err);
    if (st != RMAP_OK)
        return st;
    if (n_thread > 1 &&
        rmap_workers_start(n_thread - 1, help_to_encode, writer, &helpers, &alone) != RMAP_OK)
        helpers = NULL; /* then this thread does it all */
    st = encode_all(writer, err);
    rmap_workers_join(helpers);
    return st;
}

void rmap_trace_workers_destroy(struct rmap_trace_workers *workers)
{
    if (!workers)
        return;
    rmap_workers_join(workers->threads);
    for (int i = 0; workers->worker && i < workers->n_thread; i++) {
        rmap_cursor_destroy(workers->worker[i].cursor);
        rmap_reuse_reader_destroy(workers->worker[i].reader);
        rmap_portion_destroy(workers->worker[i].portion);
        rmap_shard_block_destroy(workers->worker[i].parts);
        rmap_tally_destroy(workers->worker[i].tally);
    }
    rmap_free(workers->worker);
    rmap_free(workers);
}
