/* SPDX-License-Identifier: MIT */
#include <time.h>

#include "base/alloc.h"
#include "io/codec/shuffle.h"
#include "io/write/shard_internal.h"

/* Until this long after the start a kill may cost all; then the interval holds. */
#define FIRST_FLUSH_SECONDS 1.0

static double clock_seconds(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void rmap_shard_flush_schedule(struct rmap_shard_writer *self)
{
    double interval = self->options.flush_seconds;
    self->flush_due =
        clock_seconds() + (interval < FIRST_FLUSH_SECONDS ? interval : FIRST_FLUSH_SECONDS);
}

bool rmap_shard_flush_has_new(const struct rmap_shard_writer *self)
{
    return self->piece && self->piece->n_portion > self->piece->n_portion_taken;
}

/* Rows of a buffer that no flush has taken, which none of its chunks before can hold. */
static enum rmap_status take_rows(struct rmap_shard_writer *self, int stream,
                                  struct rmap_error *err)
{
    const struct rmap_chunk *chunk = self->open[stream];
    struct rmap_shard_piece *piece = self->piece;
    uint64_t first = (uint64_t)chunk->index * RMAP_CHUNK_ROWS;
    uint64_t from = piece->rows_taken[stream] > first ? piece->rows_taken[stream] : first;
    size_t row = chunk->raw_nbytes / RMAP_CHUNK_ROWS;
    if (from == chunk->n_row_end)
        return RMAP_OK;
    size_t n = (size_t)(chunk->n_row_end - from);
    void *rows = rmap_alloc_unset(n, row);
    if (!rows)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a flush");
    size_t element = rmap_element_nbytes(self->queue.layout->stream[stream].element);
    size_t width = row / element;
    rmap_unshuffle(chunk->plane, RMAP_CHUNK_ROWS * width, (size_t)(from - first) * width, n * width,
                   element, rows);
    enum rmap_status st =
        rmap_journal_add_tail(&self->flush.batch, stream, from, n, row, rows, err);
    if (st == RMAP_OK)
        piece->rows_taken[stream] = chunk->n_row_end;
    rmap_free(rows);
    return st;
}

enum rmap_status rmap_shard_flush_begin(struct rmap_shard_writer *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_flush *flush = &self->flush;
    struct rmap_shard_piece *piece = self->piece;
    struct rmap_chunk *sign = NULL;
    if (flush->pending || !rmap_shard_flush_has_new(self))
        return RMAP_OK;
    RMAP_TRY(rmap_chunk_queue_take(&self->queue, RMAP_STREAM_MAX, &sign, err));
    flush->batch.nbytes = 0;
    for (int s = 0; s < self->queue.layout->n_stream; s++)
        if (self->open[s])
            RMAP_TRY(take_rows(self, s, err));
    RMAP_TRY(rmap_journal_add_portions(&flush->batch, rmap_scene_is_curved(self->run.scene),
                                       piece->portion + piece->n_portion_taken,
                                       piece->n_portion - piece->n_portion_taken, err));
    piece->n_portion_taken = piece->n_portion;
    for (int t = 0; t < RMAP_STORED_TABLE_MAX; t++)
        flush->stored_rows[t] = piece->stored_rows[t];
    flush->n_portion = piece->n_portion;
    sign->sign = RMAP_SIGN_FLUSH;
    sign->piece = piece;
    flush->pending = true;
    rmap_chunk_queue_push(&self->queue, sign);
    sign = NULL;
out:
    rmap_chunk_destroy(sign);
    return st;
}

enum rmap_status rmap_shard_flush_when_due(struct rmap_shard_writer *self, struct rmap_error *err)
{
    const struct rmap_shard_options *options = &self->options;
    if (self->flush.pending || !rmap_shard_flush_has_new(self))
        return RMAP_OK;
    uint64_t n_new = self->piece->n_portion - self->piece->n_portion_taken;
    double now = clock_seconds();
    bool by_time = options->flush_seconds > 0 && now >= self->flush_due;
    if (!by_time && (options->flush_portions == 0 || n_new < options->flush_portions))
        return RMAP_OK;
    self->flush_due = now + options->flush_seconds;
    return rmap_shard_flush_begin(self, err);
}
