/* SPDX-License-Identifier: MIT
 *
 * Getting a map ready for many questions: history indexes in memory for pieces that have none on
 * disk.
 */
#include "mpi/session/session_warm.h"

#include "base/alloc.h"
#include "io/map/map_history.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/index_run.h"
#include "mpi/scan/scan.h"

struct warming {
    const struct rmap_map *map;
    size_t *piece; /* [n_piece] that this rank reads */
    size_t n_piece;
    uint64_t budget;
    double allowed;                                 /* rmap_index_allowed */
    _Atomic uint64_t n_made, n_large, nbytes, done; /* done: rows */
    struct rmap_parts parts;
    struct rmap_progress progress;
};

static uint64_t rows_of(const struct rmap_piece_info *info)
{
    return info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT];
}

static void tick(void *context, uint64_t n_row)
{
    atomic_fetch_add(&((struct warming *)context)->done, n_row);
}

static enum rmap_status show(void *context, struct rmap_error *err)
{
    struct warming *self = context;
    (void)err;
    rmap_progress_show(&self->progress, atomic_load(&self->done));
    return RMAP_OK;
}

/* Of a piece without an index. An index has two bytes per ray or more. */
static enum rmap_status make_index(struct warming *self, size_t piece, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_bytes bytes = {0};
    const struct rmap_piece_info *info = rmap_map_piece(self->map, piece);
    const uint64_t n_ray = info->n_row[RMAP_TABLE_RAY];
    if (n_ray > self->budget / 2 || atomic_load(&self->nbytes) + 2 * n_ray > self->budget)
        return RMAP_OK; /* its columns are read, then */
    RMAP_TRY(rmap_map_history_make(self->map, piece, SIZE_MAX, tick, self, &bytes, err));
    uint64_t nbytes = bytes.head_nbytes + bytes.body_nbytes;
    if (atomic_fetch_add(&self->nbytes, nbytes) + nbytes <= self->budget)
        st = rmap_map_history_keep(self->map, piece, &bytes, err);
    if (bytes.head) { /* not taken */
        atomic_fetch_sub(&self->nbytes, nbytes);
        goto out;
    }
    atomic_fetch_add(&self->n_made, 1);
    atomic_fetch_add(&self->n_large, (double)nbytes > self->allowed * (double)info->nbytes);
out:
    rmap_free(bytes.head);
    rmap_free(bytes.body);
    return st;
}

static enum rmap_status warm(struct warming *self, size_t piece, struct rmap_error *err)
{
    const struct rmap_history_index *index = NULL;
    struct rmap_error why = {0};
    enum rmap_status st = rmap_map_history(self->map, piece, &index, &why);
    if (st == RMAP_OK && index)
        rmap_map_history_release(self->map, piece);
    else if (st == RMAP_OK)
        st = make_index(self, piece, &why);
    if (st == RMAP_SYSTEM) /* without memory columns are read; whatever else it is, they tell */
        return RMAP_OK;
    if (st != RMAP_OK)
        *err = why;
    return st;
}

static enum rmap_status warm_pieces(void *context, int thread, size_t first, size_t last,
                                    struct rmap_error *err)
{
    struct warming *self = context;
    enum rmap_status st = RMAP_OK;
    (void)thread;
    for (size_t i = first; i < last && st == RMAP_OK; i++)
        if (atomic_load(&self->nbytes) < self->budget)
            st = warm(self, self->piece[i], err);
    return st;
}

/* Sealed pieces with portions in this rank's share of a scan. */
static enum rmap_status find_pieces(struct warming *self, const struct rmap_context *context,
                                    uint64_t *n_row_ret, struct rmap_error *err)
{
    size_t first, last, n_piece = rmap_map_n_piece(self->map);
    uint8_t *read = rmap_alloc(n_piece, 1);
    self->piece = rmap_alloc(n_piece, sizeof *self->piece);
    if (!read || !self->piece) {
        rmap_free(read);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu pieces", n_piece);
    }
    rmap_scan_range(self->map, 0, rmap_map_n_portion(self->map), context->rank, context->size,
                    &first, &last);
    for (size_t p = first; p < last; p++)
        read[rmap_map_portion(self->map, p)->piece] = 1;
    for (size_t i = 0; i < n_piece; i++)
        if (read[i] && !rmap_map_piece(self->map, i)->is_open) {
            self->piece[self->n_piece++] = i;
            *n_row_ret += rows_of(rmap_map_piece(self->map, i));
        }
    rmap_free(read);
    return RMAP_OK;
}

/* Collective. */
enum rmap_status rmap_session_warm(const struct rmap_context *context, const struct rmap_map *map,
                                   uint64_t budget_nbytes, struct rmap_warmth *warmth,
                                   struct rmap_error *err)
{
    struct warming self = {.map = map, .budget = budget_nbytes, .allowed = rmap_index_allowed(map)};
    uint64_t n_row = 0;
    enum rmap_status st = find_pieces(&self, context, &n_row, err);
    RMAP_TRY(rmap_agree(context, st, err));
    self.parts.context = &self;
    self.parts.step = 1;
    self.parts.last = self.n_piece;
    self.parts.work = warm_pieces;
    self.parts.meanwhile = show;
    rmap_progress_init(&self.progress, context, "rays and segments", n_row);
    st = rmap_parts_run(&self.parts, context->n_thread, err);
    rmap_progress_fini(&self.progress);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    uint64_t sum[] = {atomic_load(&self.n_made), atomic_load(&self.n_large),
                      atomic_load(&self.nbytes)};
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPI_UINT64_T, MPI_SUM, context->comm)));
    *warmth = (struct rmap_warmth){.n_piece = sum[0], .n_large = sum[1], .nbytes = sum[2]};
out:
    rmap_free(self.piece);
    return st;
}
