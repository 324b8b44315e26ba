/* SPDX-License-Identifier: MIT
 *
 * Every rank keeps the N smallest of its own portions; rank 0 the N smallest of those.
 */
#include "mpi/scan/ray_sample.h"

#include <pthread.h>

#include "base/alloc.h"
#include "io/map/map_memory.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/scan/scan.h"

enum { TAG_COUNT = 91, TAG_RAYS };

struct search {
    const struct rmap_map *map;
    const struct rmap_pick *pick;
    const struct rmap_sample_order *order;
    const struct rmap_deal *deal;
    int rank;
    struct rmap_parts parts;
    struct rmap_picker **picker; /* [n_thread] */
    pthread_mutex_t lock;        /* of the sample */
    struct rmap_sample sample;
};

/* Whether the first ids are found and all of this portion's are larger. */
static bool is_late(struct search *self, size_t portion)
{
    if (self->order->by_hash)
        return false;
    uint64_t first = rmap_map_portion(self->map, portion)->first_ray;
    (void)pthread_mutex_lock(&self->lock);
    bool late = !rmap_sample_wants(&self->sample, rmap_sample_ray_of(self->order, first));
    (void)pthread_mutex_unlock(&self->lock);
    return late;
}

static enum rmap_status search_portion(struct search *self, struct rmap_picker *picker,
                                       size_t portion, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint8_t *match = NULL;
    const uint64_t *id = NULL;
    size_t n = 0;
    if (is_late(self, portion))
        return RMAP_OK;
    RMAP_TRY(rmap_picker_mark(picker, portion, &match, &n, err));
    if (!match)
        return RMAP_OK;
    RMAP_TRY(rmap_picker_ids(picker, portion, &id, err));
    (void)pthread_mutex_lock(&self->lock);
    for (size_t i = 0; n > 0 && st == RMAP_OK; i++)
        if (match[i]) {
            n--;
            st = rmap_sample_add(&self->sample, rmap_sample_ray_of(self->order, id[i]), err);
        }
    (void)pthread_mutex_unlock(&self->lock);
out:
    return st;
}

static enum rmap_status search_parts(void *context, int thread, size_t first, size_t last,
                                     struct rmap_error *err)
{
    struct search *self = context;
    struct rmap_picker **picker = &self->picker[thread];
    enum rmap_status st = RMAP_OK;
    if (!*picker)
        RMAP_TRY(rmap_picker_create(self->map, self->pick, picker, err));
    for (size_t k = first; k < last; k++) {
        size_t n;
        const size_t *portion = rmap_deal_part(self->deal, self->rank, k, &n);
        for (size_t i = 0; i < n && !atomic_load(&self->parts.abandoned); i++)
            RMAP_TRY(search_portion(self, *picker, portion[i], err));
    }
out:
    return st;
}

static enum rmap_status search_share(struct search *self, const struct rmap_context *context,
                                     struct rmap_error *err)
{
    size_t n_thread = (size_t)rmap_map_readers(self->map, RMAP_COLUMNS_ALL, 1, context->n_thread);
    self->picker = rmap_alloc(n_thread, sizeof *self->picker);
    if (!self->picker)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu threads", n_thread);
    self->parts.context = self;
    self->parts.last = rmap_deal_n_part(self->deal, context->rank);
    self->parts.step = 1;
    self->parts.work = search_parts;
    enum rmap_status st = rmap_parts_run(&self->parts, (int)n_thread, err);
    for (size_t i = 0; i < n_thread; i++)
        rmap_picker_destroy(self->picker[i]);
    rmap_free(self->picker);
    return st;
}

/* Rays travel some at a time: rank 0 needs room for its own sample alone. */
enum { BATCH = 1 << 16 };

static enum rmap_status send_sample(const struct search *self, const struct rmap_context *context,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t n = self->sample.n;
    RMAP_TRY(RMAP_MPI(MPI_Send(&n, 1, MPI_UINT64_T, 0, TAG_COUNT, context->comm)));
    for (size_t at = 0; at < n; at += BATCH) {
        size_t some = n - at < BATCH ? (size_t)n - at : BATCH;
        RMAP_TRY(RMAP_MPI(MPI_Send(self->sample.ray + at, (int)(2 * some), MPI_UINT64_T, 0,
                                   TAG_RAYS, context->comm)));
    }
out:
    return st;
}

static enum rmap_status receive_samples(struct search *self, const struct rmap_context *context,
                                        struct rmap_sample_ray *batch, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK, kept = RMAP_OK;
    for (int from = 1; from < context->size; from++) {
        uint64_t n = 0;
        RMAP_TRY(RMAP_MPI(
            MPI_Recv(&n, 1, MPI_UINT64_T, from, TAG_COUNT, context->comm, MPI_STATUS_IGNORE)));
        for (size_t at = 0; at < n; at += BATCH) {
            size_t some = n - at < BATCH ? (size_t)n - at : BATCH;
            RMAP_TRY(RMAP_MPI(MPI_Recv(batch, (int)(2 * some), MPI_UINT64_T, from, TAG_RAYS,
                                       context->comm, MPI_STATUS_IGNORE)));
            for (size_t i = 0; i < some && kept == RMAP_OK; i++)
                kept = rmap_sample_add(&self->sample, batch[i], err);
        }
    }
    st = kept;
out:
    return st;
}

/* Collective. */
static enum rmap_status join_samples(struct search *self, const struct rmap_context *context,
                                     uint64_t **id_ret, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t *id = NULL;
    uint8_t *blob = NULL; /* rank 0: the ids; the others get them */
    size_t nbytes = 0;
    struct rmap_sample_ray *batch = rmap_alloc(context->rank == 0 ? BATCH : 0, sizeof *batch);
    if (!batch)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sample");
    RMAP_TRY(rmap_agree(context, st, err));
    st = context->rank == 0 ? receive_samples(self, context, batch, err)
                            : send_sample(self, context, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_sample_ids(&self->sample, &id, err);
    blob = (uint8_t *)id;
    RMAP_TRY(rmap_agree(context, st, err));
    nbytes = context->rank == 0 ? self->sample.n * sizeof *id : 0;
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    *id_ret = (uint64_t *)(void *)blob;
    *n_ret = nbytes / sizeof *id;
    blob = NULL;
out:
    rmap_free(blob);
    rmap_free(batch);
    return st;
}

enum rmap_status rmap_ray_sample(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_pick *pick, enum rmap_deal_kind kind,
                                 const struct rmap_sample_order *order, uint64_t **id_ret,
                                 size_t *n_ret, struct rmap_error *err)
{
    struct rmap_deal deal = {0};
    struct search search = {.map = map,
                            .pick = pick,
                            .order = order,
                            .deal = &deal,
                            .rank = context->rank,
                            .sample = {.most = order->most}};
    (void)pthread_mutex_init(&search.lock, NULL);
    enum rmap_status st = rmap_deal_init(map, kind, context->size, &deal, err);
    if (st == RMAP_OK)
        st = search_share(&search, context, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(join_samples(&search, context, id_ret, n_ret, err));
out:
    rmap_sample_fini(&search.sample);
    (void)pthread_mutex_destroy(&search.lock);
    rmap_deal_fini(&deal);
    return st;
}
