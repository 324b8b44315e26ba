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
    uint64_t end;    /* of the rays */
    size_t n_before; /* portions that are there */
    struct rmap_held held;
    struct rmap_tally **tally;         /* [n_thread] */
    _Atomic size_t nbytes;             /* of all portions so far */
    struct rmap_reuse_reader **reader; /* [n_thread] of an older map, or NULL */
    _Atomic uint64_t n_reused;
    bool digests; /* somebody may ask for the map's */
};

/* *n_ret: so many rays from there on, which the older map has; 0: *way_ret, what it knows of this
 * one. */
static enum rmap_status take_over(struct tracing *self, int thread, uint64_t ray, uint64_t end,
                                  struct rmap_portion_recorder *history, uint64_t *n_ret,
                                  struct rmap_known_way *way_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_reuse_reader *reader = self->reader ? self->reader[thread] : NULL;
    RMAP_TRY(rmap_reuse_ready(reader, ray, end, n_ret, way_ret, err));
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
    const uint64_t first = (uint64_t)(self->n_before + index) * PORTION_RAYS;
    const uint64_t end = first + PORTION_RAYS < self->end ? first + PORTION_RAYS : self->end;
    struct rmap_portion_recorder history;
    struct rmap_tally_recorder recorder = {.tally = NULL};
    RMAP_TRY(rmap_portion_create((size_t)(end - first), scene->channels.n, portion, err));
    RMAP_TRY(rmap_portion_set_timed(*portion, scene->timed, err));
    rmap_portion_recorder_init(&history, *portion);
    rmap_portion_recorder_restart(&history, first);
    history.unpredicted.seed = self->tracer.seed;
    rmap_tally_recorder_init(&recorder, self->tally[thread], &history.base);
    for (uint64_t ray = first, n; ray < end; ray += n) {
        struct rmap_known_way way;
        RMAP_TRY(take_over(self, thread, ray, end, &history, &n, &way, err));
        if (n == 0) {
            rmap_trace_known(&self->tracer, ray, &way, &recorder.base);
            n = 1;
        }
    }
    (*portion)->unpredicted = NULL;
    if (history.status != RMAP_OK || recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the histories of rays"));
    rmap_held_describe(*portion, self->context->rank, &self->held.info[index]);
    if (self->digests)
        self->held.info[index].digest = rmap_portion_digest(*portion);
    if (atomic_fetch_add(&self->nbytes, rmap_held_nbytes(*portion)) > RMAP_HELD_NBYTES_MAX)
        st = rmap_error_set(
            err, RMAP_USAGE,
            "%llu rays take more memory than %d MiB: fewer rays, more ranks, or a map on disk "
            "(raymap trace; 'keep: maps' of a sweep)",
            (unsigned long long)self->end, (int)(RMAP_HELD_NBYTES_MAX >> 20));
out:
    rmap_tally_recorder_fini(&recorder);
    return st;
}

/* The first of the new portions that is a rank's: of all of them it has every size-th. */
static size_t first_of(const struct tracing *self, int rank)
{
    const size_t size = (size_t)self->context->size;
    return (size + (size_t)rank - self->n_before % size) % size;
}

static enum rmap_status trace_some(void *context, int thread, size_t first, size_t last,
                                   struct rmap_error *err)
{
    struct tracing *self = context;
    enum rmap_status st = RMAP_OK;
    const size_t size = (size_t)self->context->size;
    for (size_t i = first; i < last && st == RMAP_OK; i++)
        st = trace_portion(self, thread, first_of(self, self->context->rank) + i * size, err);
    return st;
}

/* This rank's part: every size-th portion. */
static enum rmap_status trace_share(struct tracing *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t mine = first_of(self, self->context->rank), size = (size_t)self->context->size;
    const size_t n = self->held.n > mine ? (self->held.n - mine - 1) / size + 1 : 0;
    struct rmap_parts parts = {.last = n, .step = 1, .context = self, .work = trace_some};
    for (int i = 0; i < self->context->n_thread; i++)
        RMAP_TRY(rmap_tally_create(self->tracer.scene, &self->tally[i], err));
    RMAP_TRY(rmap_parts_run(&parts, self->context->n_thread, err));
    for (int i = 1; i < self->context->n_thread; i++)
        rmap_tally_merge(self->tally[0], self->tally[i]);
out:
    return st;
}

static enum rmap_status create_readers(struct tracing *self, const struct rmap_reuse *reuse,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_thread = (size_t)self->context->n_thread;
    self->reader = rmap_alloc(n_thread, sizeof *self->reader);
    if (!self->reader)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu threads", n_thread);
    for (size_t i = 0; i < n_thread && st == RMAP_OK; i++)
        st = rmap_reuse_reader_create(reuse, &self->reader[i], err);
    return st;
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
                                    (int)((self->n_before + i) % (size_t)context->size),
                                    context->comm)));
out:
    return st;
}

/* Collective. The map grows; self: context, tracer, end, digests. */
static enum rmap_status grow(struct tracing *self, const struct rmap_reuse *reuse,
                             struct rmap_map *map, double *seconds_ret, uint64_t *reused_ret,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    const size_t n_before = rmap_map_n_portion(map);
    const size_t n_all = (size_t)((self->end + PORTION_RAYS - 1) / PORTION_RAYS);
    const size_t n = n_all > n_before ? n_all - n_before : 0;
    self->n_before = n_before;
    self->held = (struct rmap_held){.n = n,
                                    .info = rmap_alloc(n + 1, sizeof *self->held.info),
                                    .portion = rmap_alloc(n + 1, sizeof *self->held.portion),
                                    .n_rank = context->size,
                                    .seed = self->tracer.seed};
    self->tally = rmap_alloc((size_t)context->n_thread, sizeof *self->tally);
    self->nbytes = rmap_map_held_nbytes(map);
    if (!self->held.info || !self->held.portion || !self->tally)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    RMAP_TRY(rmap_agree(context, st, err));
    const double begun = rmap_clock_seconds();
    if (reuse->n > 0)
        st = create_readers(self, reuse, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = trace_share(self, err);
    *reused_ret += atomic_load(&self->n_reused);
    *seconds_ret += rmap_clock_seconds() - begun;
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->size > 1)
        RMAP_TRY(share_rows(self, err));
    st = rmap_agree(context, rmap_map_hold_more(map, &self->held, self->tally[0], err), err);
out:
    for (int i = 0; self->reader && i < context->n_thread; i++)
        rmap_reuse_reader_destroy(self->reader[i]);
    rmap_free(self->reader);
    for (int i = 0; self->tally && i < context->n_thread; i++)
        rmap_tally_destroy(self->tally[i]);
    rmap_free(self->tally);
    rmap_held_fini(&self->held);
    return st;
}

enum rmap_status rmap_trace_held_more(const struct rmap_context *context,
                                      const struct rmap_accel *accel,
                                      const struct rmap_reuse *reuse, uint64_t end,
                                      struct rmap_map *map, double *seconds_ret,
                                      uint64_t *reused_ret, struct rmap_error *err)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    struct tracing self = {.context = context,
                           .tracer = {rmap_map_scene(map), accel, summary.seed},
                           .end = end,
                           .digests = true};
    return grow(&self, reuse, map, seconds_ret, reused_ret, err);
}

enum rmap_status rmap_trace_held(const struct rmap_context *context, struct rmap_trace_held *trace,
                                 struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_accel *accel = NULL;
    struct rmap_map *map = NULL;
    struct rmap_reuse reuse = {.n = 0};
    enum rmap_status st =
        trace->accel && *trace->accel
            ? rmap_accel_create_like(*trace->accel, trace->scene, &accel, err)
            : rmap_accel_create_isa(trace->scene, context->n_thread, trace->isa_level, &accel, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_map_hold(context->size, trace->seed, trace->scene, &map, err);
    if (st == RMAP_OK)
        trace->scene = NULL;
    RMAP_TRY(rmap_agree(context, st, err));
    if (trace->from)
        st = rmap_reuse_init(&reuse, trace->from, 0, rmap_map_scene(map), err);
    RMAP_TRY(rmap_agree(context, st, err));
    struct tracing self = {.context = context,
                           .tracer = {rmap_map_scene(map), accel, trace->seed},
                           .end = trace->n_ray};
    RMAP_TRY(grow(&self, &reuse, map, &trace->seconds, &trace->n_reused, err));
    *map_ret = map;
    map = NULL;
    if (trace->accel) {
        rmap_accel_destroy(*trace->accel);
        *trace->accel = accel;
        accel = NULL;
    }
out:
    rmap_reuse_fini(&reuse);
    rmap_map_close(map);
    rmap_accel_destroy(accel);
    return st;
}
