/* SPDX-License-Identifier: MIT */
#include "mpi/index_run.h"

#include <pthread.h>

#include "base/alloc.h"
#include "io/history_file.h"
#include "io/map_history.h"
#include "mpi/agree.h"
#include "mpi/load.h"
#include "mpi/parts.h"
#include "mpi/progress.h"

struct indexing {
    struct rmap_map *map;
    const char *path;
    bool remake;
    struct rmap_parts parts;
    struct rmap_progress progress;
    _Atomic uint64_t done; /* rows */
    pthread_mutex_t lock;  /* of files: HDF5 is used by one thread at a time */
    uint64_t n_piece, n_made;
};

static uint64_t rows_of(const struct rmap_piece_info *info)
{
    return info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT];
}

static double piece_rows(void *context, size_t piece)
{
    return (double)rows_of(rmap_map_piece(((struct indexing *)context)->map, piece));
}

static void tick(void *context, uint64_t n_row)
{
    struct indexing *self = context;
    atomic_fetch_add(&self->done, n_row);
}

static enum rmap_status show(void *context, struct rmap_error *err)
{
    struct indexing *self = context;
    (void)err;
    rmap_progress_show(&self->progress, atomic_load(&self->done));
    return RMAP_OK;
}

static bool is_there(struct indexing *self, size_t piece)
{
    (void)pthread_mutex_lock(&self->lock);
    bool there = !self->remake && rmap_map_history_open(self->map, piece, NULL, NULL) == RMAP_OK;
    (void)pthread_mutex_unlock(&self->lock);
    return there;
}

static enum rmap_status make(struct indexing *self, size_t piece, struct rmap_error *err)
{
    uint64_t nbytes = 0;
    struct rmap_history_bytes bytes = {0};
    enum rmap_status st = rmap_map_history_make(self->map, piece, tick, self, &bytes, err);
    if (st == RMAP_OK) {
        (void)pthread_mutex_lock(&self->lock);
        st = rmap_history_file_write(self->path, rmap_map_piece(self->map, piece), &bytes, &nbytes,
                                     err);
        self->n_made += st == RMAP_OK;
        (void)pthread_mutex_unlock(&self->lock);
    }
    rmap_free(bytes.head);
    rmap_free(bytes.body);
    return st;
}

static enum rmap_status index_pieces(void *context, int thread, size_t first, size_t last,
                                     struct rmap_error *err)
{
    struct indexing *self = context;
    enum rmap_status st = RMAP_OK;
    (void)thread;
    for (size_t i = first; i < last && st == RMAP_OK; i++) {
        const struct rmap_piece_info *info = rmap_map_piece(self->map, i);
        if (info->is_open)
            continue; /* its end is to come */
        (void)pthread_mutex_lock(&self->lock);
        self->n_piece++;
        (void)pthread_mutex_unlock(&self->lock);
        if (is_there(self, i))
            tick(self, rows_of(info));
        else
            st = make(self, i, err);
    }
    return st;
}

/* Collective. */
static enum rmap_status sum_up(const struct rmap_context *context, const struct indexing *self,
                               struct rmap_index_result *result, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary summary;
    uint64_t sum[] = {self->n_piece, self->n_made};
    size_t n_file = 0;
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_UINT64_T, MPI_SUM, context->comm)));
    rmap_map_summarise(self->map, &summary);
    result->n_piece = sum[0];
    result->n_made = sum[1];
    result->map_nbytes = summary.nbytes;
    st = rmap_map_history_measure(self->map, &n_file, &result->nbytes, err);
out:
    return rmap_agree(context, st, err);
}

enum rmap_status rmap_index_run(const struct rmap_context *context, const char *path, bool remake,
                                struct rmap_index_result *result, struct rmap_error *err)
{
    struct indexing self = {.path = path, .remake = remake};
    double begun = rmap_clock_seconds(), total = 0.0;
    *result = (struct rmap_index_result){0};
    (void)pthread_mutex_init(&self.lock, NULL);
    enum rmap_status st = rmap_load_map(context, path, &self.map, err);
    RMAP_TRY(st);
    self.parts.context = &self;
    self.parts.step = 1;
    self.parts.work = index_pieces;
    self.parts.meanwhile = show;
    rmap_parts_share(&self.parts, piece_rows, rmap_map_n_piece(self.map), context->rank,
                     context->size);
    for (size_t i = self.parts.first; i < self.parts.last; i++)
        total += piece_rows(&self, i);
    rmap_progress_init(&self.progress, context, "rays and segments", (uint64_t)total);
    st = rmap_parts_run(&self.parts, context->n_thread, err);
    rmap_progress_fini(&self.progress);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(sum_up(context, &self, result, err));
    result->seconds = rmap_clock_seconds() - begun;
out:
    rmap_map_close(self.map);
    (void)pthread_mutex_destroy(&self.lock);
    return st;
}
