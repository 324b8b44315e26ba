/* SPDX-License-Identifier: MIT
 *
 * The rays of a scene traced into memory, in the blocks of a map: statistics round once per block,
 * and are to have the same last bit as those of a map.
 */
#include "mpi/trace/trace_held.h"

#include <stdatomic.h>

#include "accel/accel.h"
#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/parallel/tally_reduce.h"
#include "mpi/trace/trace_reuse.h"
#include "portion/portion_recorder.h"
#include "trace/tracer.h"

enum { PORTION_RAYS = RMAP_BLOCK_RAYS };

struct tracing {
    const struct rmap_context *context;
    struct rmap_tracer tracer;
    uint64_t n_ray;
    struct rmap_held held;
    struct rmap_tally **tally; /* [n_thread] */
    _Atomic size_t nbytes;     /* of all portions so far */
    struct rmap_touch touch;
    struct rmap_reuse reuse;           /* of the older map; n 0: nothing of it */
    struct rmap_reuse_reader **reader; /* [n_thread], or NULL */
    _Atomic uint64_t n_reused;
};

static size_t nbytes_of(const struct rmap_portion *portion)
{
    size_t nbytes = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (rmap_portion_column(portion, (enum rmap_column)c))
            nbytes += rmap_portion_row_nbytes(portion, (enum rmap_column)c) *
                      portion->cap[rmap_column_info((enum rmap_column)c)->table];
    return nbytes;
}

/* *n_ret: so many rays from there on, which the older map has. */
static enum rmap_status take_over(struct tracing *self, int thread, uint64_t ray, uint64_t end,
                                  struct rmap_portion_recorder *history, uint64_t *n_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_reuse_reader *reader = self->reader ? self->reader[thread] : NULL;
    *n_ret = 0;
    if (reader)
        RMAP_TRY(rmap_reuse_ready(reader, ray, end, n_ret, err));
    if (*n_ret > 0)
        RMAP_TRY(rmap_reuse_take(reader, *n_ret, history, self->tally[thread], err));
    atomic_fetch_add(&self->n_reused, *n_ret);
out:
    return st;
}

static enum rmap_status trace_portion(struct tracing *self, int thread, size_t index,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = self->tracer.scene;
    struct rmap_portion **portion = &self->held.portion[index];
    const uint64_t first = (uint64_t)index * PORTION_RAYS;
    const uint64_t end = first + PORTION_RAYS < self->n_ray ? first + PORTION_RAYS : self->n_ray;
    struct rmap_portion_recorder history;
    struct rmap_tally_recorder recorder = {.tally = NULL};
    RMAP_TRY(rmap_portion_create((size_t)(end - first), scene->channels.n, portion, err));
    RMAP_TRY(rmap_portion_set_timed(*portion, scene->timed, err));
    rmap_portion_recorder_init(&history, *portion);
    rmap_portion_recorder_restart(&history, first);
    history.unpredicted.seed = self->tracer.seed;
    rmap_tally_recorder_init(&recorder, self->tally[thread], &history.base);
    for (uint64_t ray = first, n; ray < end; ray += n) {
        RMAP_TRY(take_over(self, thread, ray, end, &history, &n, err));
        if (n == 0) {
            rmap_trace_ray(&self->tracer, ray, &recorder.base);
            n = 1;
        }
    }
    (*portion)->unpredicted = NULL;
    if (history.status != RMAP_OK || recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the histories of rays"));
    rmap_held_describe(*portion, self->context->rank, &self->held.info[index]);
    if (atomic_fetch_add(&self->nbytes, nbytes_of(*portion)) > RMAP_HELD_NBYTES_MAX)
        st = rmap_error_set(
            err, RMAP_USAGE,
            "%llu rays take more memory than %d MiB: fewer rays, more ranks, or a map on disk "
            "(raymap trace; 'keep: maps' of a sweep)",
            (unsigned long long)self->n_ray, (int)(RMAP_HELD_NBYTES_MAX >> 20));
out:
    rmap_tally_recorder_fini(&recorder);
    return st;
}

static enum rmap_status trace_some(void *context, int thread, size_t first, size_t last,
                                   struct rmap_error *err)
{
    struct tracing *self = context;
    enum rmap_status st = RMAP_OK;
    const size_t rank = (size_t)self->context->rank, size = (size_t)self->context->size;
    for (size_t i = first; i < last && st == RMAP_OK; i++)
        st = trace_portion(self, thread, rank + i * size, err);
    return st;
}

/* This rank's part: every size-th portion. */
static enum rmap_status trace_share(struct tracing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t rank = (size_t)self->context->rank, size = (size_t)self->context->size;
    const size_t n = self->held.n > rank ? (self->held.n - rank - 1) / size + 1 : 0;
    struct rmap_parts parts = {.last = n, .step = 1, .context = self, .work = trace_some};
    for (int i = 0; i < self->context->n_thread; i++)
        RMAP_TRY(rmap_tally_create(self->tracer.scene, &self->tally[i], err));
    RMAP_TRY(rmap_parts_run(&parts, self->context->n_thread, err));
    for (int i = 1; i < self->context->n_thread; i++)
        rmap_tally_merge(self->tally[0], self->tally[i]);
out:
    return st;
}

/* What of the older map the scene has, too. */
static enum rmap_status look_back(struct tracing *self, const struct rmap_map *from,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_thread = (size_t)self->context->n_thread;
    RMAP_TRY(rmap_touch_init(&self->touch, rmap_map_scene(from), self->tracer.scene, err));
    if (self->touch.change.all[0])
        goto out;
    RMAP_TRY(rmap_reuse_init(&self->reuse, from, 0, &self->touch, err));
    self->reader = rmap_alloc(n_thread, sizeof *self->reader);
    if (!self->reader)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu threads", n_thread);
    for (size_t i = 0; i < n_thread && st == RMAP_OK; i++)
        st = rmap_reuse_reader_create(&self->reuse, &self->reader[i], err);
out:
    return st;
}

static void forget(struct tracing *self)
{
    for (int i = 0; self->reader && i < self->context->n_thread; i++)
        rmap_reuse_reader_destroy(self->reader[i]);
    rmap_free(self->reader);
    rmap_reuse_fini(&self->reuse);
    rmap_touch_fini(&self->touch);
}

/* Collective. All ranks get the sums and the portions' rows. */
static enum rmap_status share_rows(struct tracing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    struct rmap_tally *tally = self->tally[0];
    RMAP_TRY(rmap_tally_reduce(context, tally, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(tally->value, (int)tally->n_value, MPI_DOUBLE, 0, context->comm)));
    for (size_t i = 0; i < self->held.n; i++)
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&self->held.info[i], sizeof *self->held.info, MPI_BYTE,
                                    (int)(i % (size_t)context->size), context->comm)));
out:
    return st;
}

enum rmap_status rmap_trace_held(const struct rmap_context *context, struct rmap_scene *scene,
                                 uint64_t seed, uint64_t n_ray, int isa_level,
                                 struct rmap_map **map_ret, double *seconds_ret,
                                 struct rmap_error *err)
{
    uint64_t reused = 0;
    return rmap_trace_held_from(context, NULL, scene, seed, n_ray, isa_level, map_ret, seconds_ret,
                                &reused, err);
}

enum rmap_status rmap_trace_held_from(const struct rmap_context *context,
                                      const struct rmap_map *from, struct rmap_scene *scene,
                                      uint64_t seed, uint64_t n_ray, int isa_level,
                                      struct rmap_map **map_ret, double *seconds_ret,
                                      uint64_t *reused_ret, struct rmap_error *err)
{
    struct rmap_accel *accel = NULL;
    const size_t n = (size_t)((n_ray + PORTION_RAYS - 1) / PORTION_RAYS);
    struct tracing self = {.context = context,
                           .n_ray = n_ray,
                           .held = {.n = n,
                                    .info = rmap_alloc(n, sizeof *self.held.info),
                                    .portion = rmap_alloc(n, sizeof *self.held.portion),
                                    .n_rank = context->size,
                                    .seed = seed},
                           .tally = rmap_alloc((size_t)context->n_thread, sizeof *self.tally)};
    enum rmap_status st = rmap_accel_create_isa(scene, context->n_thread, isa_level, &accel, err);
    if (st == RMAP_OK && (!self.held.info || !self.held.portion || !self.tally))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    RMAP_TRY(rmap_agree(context, st, err));
    self.tracer = (struct rmap_tracer){scene, accel, seed};
    const double begun = rmap_clock_seconds();
    if (from)
        st = look_back(&self, from, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = trace_share(&self, err);
    *reused_ret += atomic_load(&self.n_reused);
    *seconds_ret += rmap_clock_seconds() - begun;
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->size > 1)
        RMAP_TRY(share_rows(&self, err));
    st = rmap_map_hold(&self.held, scene, self.tally[0], map_ret, err);
    if (st == RMAP_OK)
        self.tally[0] = NULL;
    st = rmap_agree(context, st, err);
out:
    forget(&self);
    for (int i = 0; self.tally && i < context->n_thread; i++)
        rmap_tally_destroy(self.tally[i]);
    rmap_free(self.tally);
    rmap_held_fini(&self.held);
    rmap_accel_destroy(accel);
    return st;
}
