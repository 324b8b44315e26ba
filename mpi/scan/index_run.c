/* SPDX-License-Identifier: MIT
 *
 * Making the history indexes of a map: each piece on whichever thread of whichever rank is free.
 */
#include "mpi/scan/index_run.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/history_file.h"
#include "io/map/map_history.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"

/* Indexes take at most this part of the map, and what a small map may have, shared out over its
 * pieces. */
enum { SHARE_OF_MAP = 10, SMALL_NBYTES = 64 << 10, EARLY = 2 };

struct indexing {
    struct rmap_map *map;
    const char *path;
    int flags;
    double allowed; /* bytes of an index for each byte of its piece */
    struct rmap_parts parts;
    struct rmap_progress progress;
    _Atomic uint64_t done; /* rows */
    pthread_mutex_t lock;  /* of files: HDF5 is used by one thread at a time */
    uint64_t n_piece, n_made, n_large, large_nbytes;
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

static void count(void *context, uint64_t n_row)
{
    *(uint64_t *)context += n_row;
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
    bool there = !(self->flags & RMAP_INDEX_REMAKE) &&
                 rmap_map_history_open(self->map, piece, NULL, NULL) == RMAP_OK;
    (void)pthread_mutex_unlock(&self->lock);
    return there;
}

double rmap_index_allowed(const struct rmap_map *map)
{
    struct rmap_map_summary summary;
    double nbytes = 0.0;
    rmap_map_summarise(map, &summary);
    for (size_t i = 0; i < rmap_map_n_piece(map); i++)
        nbytes += (double)rmap_map_piece(map, i)->nbytes;
    return ((double)summary.nbytes / SHARE_OF_MAP + SMALL_NBYTES) / fmax(nbytes, 1.0);
}

static bool is_large(const struct indexing *self, size_t piece,
                     const struct rmap_history_bytes *bytes)
{
    return (double)(bytes->head_nbytes + bytes->body_nbytes) >
           self->allowed * (double)rmap_map_piece(self->map, piece)->nbytes;
}

static void leave(struct indexing *self, uint64_t nbytes)
{
    (void)pthread_mutex_lock(&self->lock);
    self->n_large++;
    self->large_nbytes += nbytes;
    (void)pthread_mutex_unlock(&self->lock);
}

/* Whether a piece is left without, by what its first portion takes: where that speaks of twice as
 * much as there may be, the others are not read, or traced again, for nothing. */
static enum rmap_status leave_early(struct indexing *self, size_t piece, bool *left_ret,
                                    struct rmap_error *err)
{
    const struct rmap_piece_info *info = rmap_map_piece(self->map, piece);
    struct rmap_history_bytes bytes = {0};
    uint64_t n_row = 0;
    enum rmap_status st = RMAP_OK;
    *left_ret = false;
    if (self->flags & RMAP_INDEX_LARGE)
        return RMAP_OK;
    RMAP_TRY(rmap_map_history_make(self->map, piece, 1, count, &n_row, &bytes, err));
    const double nbytes = (double)(bytes.head_nbytes + bytes.body_nbytes) * (double)rows_of(info) /
                          fmax((double)n_row, 1.0);
    if (nbytes > EARLY * self->allowed * (double)info->nbytes) {
        leave(self, (uint64_t)nbytes);
        tick(self, rows_of(info));
        *left_ret = true;
    }
out:
    rmap_free(bytes.head);
    rmap_free(bytes.body);
    return st;
}

static enum rmap_status make(struct indexing *self, size_t piece, struct rmap_error *err)
{
    uint64_t nbytes = 0;
    struct rmap_history_bytes bytes = {0};
    bool left = false;
    enum rmap_status st = leave_early(self, piece, &left, err);
    if (st != RMAP_OK || left)
        return st;
    st = rmap_map_history_make(self->map, piece, SIZE_MAX, tick, self, &bytes, err);
    if (st == RMAP_OK && !(self->flags & RMAP_INDEX_LARGE) && is_large(self, piece, &bytes)) {
        leave(self, bytes.head_nbytes + bytes.body_nbytes);
    } else if (st == RMAP_OK) {
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
    uint64_t sum[] = {self->n_piece, self->n_made, self->n_large, self->large_nbytes};
    size_t n_file = 0;
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPI_UINT64_T, MPI_SUM, context->comm)));
    rmap_map_summarise(self->map, &summary);
    result->n_piece = sum[0];
    result->n_made = sum[1];
    result->n_large = sum[2];
    result->large_nbytes = sum[3];
    result->map_nbytes = summary.nbytes;
    st = rmap_map_history_measure(self->map, &n_file, &result->nbytes, err);
out:
    return rmap_agree(context, st, err);
}

void rmap_index_tell_large(const struct rmap_index_result *result, char *line, size_t cap)
{
    line[0] = 0;
    if (result->n_large > 0)
        (void)snprintf(line, cap,
                       "%s %s left without: indexes would take about %.1f MB, and more "
                       "than a tenth of the map (raymap index --large makes them)",
                       rmap_counted(result->n_large, "piece").text,
                       result->n_large == 1 ? "is" : "are", 1e-6 * (double)result->large_nbytes);
}

enum rmap_status rmap_index_run(const struct rmap_context *context, const char *path, int flags,
                                struct rmap_index_result *result, struct rmap_error *err)
{
    struct indexing self = {.path = path, .flags = flags};
    double begun = rmap_clock_seconds(), total = 0.0;
    *result = (struct rmap_index_result){0};
    (void)pthread_mutex_init(&self.lock, NULL);
    enum rmap_status st = rmap_load_map(context, path, &self.map, err);
    RMAP_TRY(st);
    self.allowed = rmap_index_allowed(self.map);
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
