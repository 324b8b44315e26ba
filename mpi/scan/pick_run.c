/* SPDX-License-Identifier: MIT
 *
 * A thread takes a run of portions after the other, gathers the rays it picks until a block is full
 * and appends that to the rank's shard of its colour space. Blocks end where a run does, so rays of
 * one block lie near each other in the map that is asked.
 */
#include "mpi/scan/pick_run.h"

#include <pthread.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_memory.h"
#include "io/map/map_run.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_content.h"
#include "mpi/parallel/nap.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/parallel/tally_reduce.h"
#include "mpi/scan/scan.h"

/* Parts of the deal that a thread takes at a time: few matches make few blocks. */
enum { PARTS = 4 };

/* A thread has the rows that it evaluates, those of whole rays, and a block of those picked. */
enum { COPIES = 3 };

/* Threads wait for the disk rather than fill the memory; bytes per rank. */
static const size_t backlog_nbytes = (size_t)64 << 20;

/* A colour space of the map: a shard of its own. */
struct space {
    struct rmap_map_run run;
    struct rmap_shard_writer *writer;
};

struct picking {
    const struct rmap_context *context;
    const struct rmap_pick_plan *plan;
    struct rmap_deal deal;
    struct rmap_parts parts;
    struct space *space; /* [n_space] */
    size_t n_space;
    int n_thread;          /* as many as fit into a query's memory */
    struct worker *worker; /* [n_thread] */
    pthread_mutex_t lock;  /* of the tally */
    struct rmap_tally *tally;
    struct rmap_progress progress;
    _Atomic uint64_t n_ray; /* looked at */
};

/* Rays of a colour space until there are enough. */
struct block {
    struct rmap_portion *rays; /* NULL: none yet */
    struct rmap_unpredicted unpredicted;
};

struct worker {
    struct rmap_picker *picker;
    struct block *block; /* [n_space] */
};

static size_t backlog(const struct picking *self)
{
    size_t nbytes = 0;
    for (size_t i = 0; i < self->n_space; i++)
        nbytes += self->space[i].writer ? rmap_shard_writer_backlog(self->space[i].writer) : 0;
    return nbytes;
}

static enum rmap_status encode_chunks(struct picking *self, struct rmap_shard_writer *writer,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (bool did = true; did && st == RMAP_OK;)
        st = rmap_shard_writer_encode(writer, &did, err);
    while (st == RMAP_OK && !atomic_load(&self->parts.abandoned) && backlog(self) > backlog_nbytes)
        rmap_nap();
    return st;
}

/* Writes a block and empties it. */
static enum rmap_status write_block(struct picking *self, size_t space, struct block *block,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_writer *writer = self->space[space].writer;
    if (!block->rays || block->rays->n_row[RMAP_TABLE_RAY] == 0)
        return RMAP_OK;
    (void)pthread_mutex_lock(&self->lock);
    st = rmap_tally_add_portion(self->tally, block->rays, err);
    (void)pthread_mutex_unlock(&self->lock);
    RMAP_TRY(st);
    block->rays->unpredicted = &block->unpredicted;
    RMAP_TRY(rmap_shard_writer_append(writer, block->rays, err));
    RMAP_TRY(encode_chunks(self, writer, err));
    rmap_portion_clear(block->rays);
out:
    return st;
}

static enum rmap_status add_rays(struct picking *self, size_t space, struct block *block,
                                 const struct rmap_portion *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t segment = 0, registration = 0;
    if (!block->rays)
        RMAP_TRY(rmap_portion_create(0, rays->n_channel, &block->rays, err));
    for (size_t i = 0, n; i < rays->n_row[RMAP_TABLE_RAY]; i += n) {
        size_t before[RMAP_TABLE_COUNT];
        memcpy(before, block->rays->n_row, sizeof before);
        const size_t left = rays->n_row[RMAP_TABLE_RAY] - i;
        const size_t room = RMAP_BLOCK_RAYS - before[RMAP_TABLE_RAY];
        n = left < room ? left : room;
        if (room == RMAP_BLOCK_RAYS)
            block->unpredicted = (struct rmap_unpredicted){.seed = self->space[space].run.run.seed};
        RMAP_TRY(rmap_portion_append_rays(block->rays, rays, i, n, segment, registration, err));
        rmap_unpredicted_take(&block->unpredicted, rays->unpredicted, i, i + n,
                              before[RMAP_TABLE_RAY]);
        segment += block->rays->n_row[RMAP_TABLE_SEGMENT] - before[RMAP_TABLE_SEGMENT];
        registration +=
            block->rays->n_row[RMAP_TABLE_REGISTRATION] - before[RMAP_TABLE_REGISTRATION];
        if (n == room)
            RMAP_TRY(write_block(self, space, block, err));
    }
out:
    return st;
}

static enum rmap_status pick_portion(struct picking *self, struct worker *worker, size_t portion,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(self->plan->map, portion);
    size_t space = (size_t)info->space, n = 0;
    const uint8_t *match = NULL;
    const struct rmap_portion *rays = NULL;
    RMAP_TRY(rmap_picker_mark(worker->picker, portion, &match, &n, err));
    if (match) {
        RMAP_TRY(rmap_picker_read(worker->picker, portion, match, n, &rays, err));
        RMAP_TRY(add_rays(self, space, &worker->block[space], rays, err));
    }
    atomic_fetch_add(&self->n_ray, info->n_row[RMAP_TABLE_RAY]);
out:
    return st;
}

static enum rmap_status pick_parts(void *context, int thread, size_t first, size_t last,
                                   struct rmap_error *err)
{
    struct picking *self = context;
    struct worker *worker = &self->worker[thread];
    enum rmap_status st = RMAP_OK;
    if (!worker->picker)
        RMAP_TRY(rmap_picker_create(self->plan->map, self->plan->pick, &worker->picker, err));
    for (size_t k = first; k < last; k++) {
        size_t n;
        const size_t *portion = rmap_deal_part(&self->deal, self->context->rank, k, &n);
        for (size_t i = 0; i < n && !atomic_load(&self->parts.abandoned); i++)
            RMAP_TRY(pick_portion(self, worker, portion[i], err));
    }
    for (size_t space = 0; space < self->n_space; space++)
        RMAP_TRY(write_block(self, space, &worker->block[space], err));
out:
    return st;
}

/* Rank 0 shows how far its own share has come. */
static enum rmap_status store(void *context, struct rmap_error *err)
{
    struct picking *self = context;
    enum rmap_status st = RMAP_OK;
    rmap_progress_show(&self->progress, atomic_load(&self->n_ray));
    for (size_t i = 0; i < self->n_space; i++)
        if (self->space[i].writer)
            RMAP_TRY(rmap_shard_writer_store(self->space[i].writer, err));
out:
    return st;
}

/* Whether the rank has portions of the space: only then is there a shard. */
static bool has_space(const struct picking *self, size_t space)
{
    int rank = self->context->rank;
    bool has = false;
    for (size_t i = self->deal.first[rank]; i < self->deal.first[rank + 1] && !has; i++)
        has = (size_t)rmap_map_portion(self->plan->map, self->deal.portion[i])->space == space;
    return has;
}

static enum rmap_status open_spaces(struct picking *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_pick_plan *plan = self->plan;
    /* Picking that is killed is begun again: nothing is flushed. */
    const struct rmap_shard_options options = {0};
    self->space = rmap_alloc(self->n_space, sizeof *self->space);
    if (!self->space)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the map's shards");
    for (size_t i = 0; i < self->n_space; i++) {
        int shard = self->context->rank + (int)i * self->context->size;
        if (!has_space(self, i))
            continue;
        RMAP_TRY(rmap_map_run_init(plan->map, i, plan->encoding, &self->space[i].run, err));
        self->space[i].run.run.selection = plan->selection;
        RMAP_TRY(rmap_shard_writer_create(plan->to, shard, &self->space[i].run.run, &options,
                                          &self->space[i].writer, err));
    }
out:
    return st;
}

static enum rmap_status make_workers(struct picking *self, struct rmap_error *err)
{
    int n_thread = self->n_thread =
        rmap_map_readers(self->plan->map, RMAP_COLUMNS_ALL, COPIES, self->context->n_thread);
    self->worker = rmap_alloc((size_t)n_thread, sizeof *self->worker);
    for (int i = 0; self->worker && i < n_thread; i++) {
        self->worker[i].block = rmap_alloc(self->n_space, sizeof *self->worker[i].block);
        if (!self->worker[i].block)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    }
    return self->worker
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
}

static enum rmap_status pick_share(struct picking *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int rank = self->context->rank;
    uint64_t n_ray = 0;
    RMAP_TRY(open_spaces(self, err));
    RMAP_TRY(make_workers(self, err));
    self->parts.context = self;
    self->parts.last = rmap_deal_n_part(&self->deal, rank);
    self->parts.step = PARTS;
    self->parts.work = pick_parts;
    self->parts.meanwhile = store;
    for (size_t i = self->deal.first[rank]; i < self->deal.first[rank + 1]; i++)
        n_ray += rmap_map_portion(self->plan->map, self->deal.portion[i])->n_row[RMAP_TABLE_RAY];
    rmap_progress_init(&self->progress, self->context, "rays", n_ray);
    st = rmap_parts_run(&self->parts, self->n_thread, err);
    rmap_progress_fini(&self->progress);
    for (size_t i = 0; i < self->n_space && st == RMAP_OK; i++)
        if (self->space[i].writer)
            st = rmap_shard_writer_finish(self->space[i].writer, err);
out:
    return st;
}

static void picking_fini(struct picking *self)
{
    for (int i = 0; self->worker && i < self->n_thread; i++) {
        for (size_t k = 0; self->worker[i].block && k < self->n_space; k++)
            rmap_portion_destroy(self->worker[i].block[k].rays);
        rmap_free(self->worker[i].block);
        rmap_picker_destroy(self->worker[i].picker);
    }
    rmap_free(self->worker);
    for (size_t i = 0; self->space && i < self->n_space; i++) {
        rmap_shard_writer_destroy(self->space[i].writer);
        rmap_map_run_fini(&self->space[i].run);
    }
    rmap_free(self->space);
    rmap_deal_fini(&self->deal);
    (void)pthread_mutex_destroy(&self->lock);
}

enum rmap_status rmap_pick_run(const struct rmap_context *context,
                               const struct rmap_pick_plan *plan, struct rmap_map_content *content,
                               struct rmap_tally *tally, struct rmap_error *err)
{
    struct picking self = {
        .context = context, .plan = plan, .n_space = rmap_map_n_space(plan->map), .tally = tally};
    (void)pthread_mutex_init(&self.lock, NULL);
    enum rmap_status st = rmap_deal_init(plan->map, plan->deal, context->size, &self.deal, err);
    if (st == RMAP_OK)
        st = pick_share(&self, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    for (size_t i = 0; i < self.n_space; i++) {
        const struct rmap_shard_writer *writer = self.space[i].writer;
        RMAP_TRY(rmap_gather_content(context, writer ? rmap_shard_writer_content(writer) : NULL,
                                     content, err));
    }
    RMAP_TRY(rmap_tally_reduce(context, tally, err));
out:
    picking_fini(&self);
    return st;
}
