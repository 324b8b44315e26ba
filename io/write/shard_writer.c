/* SPDX-License-Identifier: MIT
 *
 * A shard's buffers under one lock; encoding outside any lock; HDF5 in one thread.
 *
 * A full buffer goes to a queue that keeps the order of filling, so the file does not
 * depend on which thread encoded what. A piece ends between two portions: its buffers are flushed
 * as they are, and a sign in the queue tells the writing thread to close it. A flush is such a sign
 * too: when it comes out, all that was appended before it is stored or in the sign's batch.
 */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "base/alloc.h"
#include "compact/path_book.h"
#include "io/codec/shuffle.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"
#include "io/map/provenance.h"
#include "io/write/shard_internal.h"
#include "io/write/shard_writer.h"

/* Until this long after the start a kill may cost all; then the interval holds. */
#define FIRST_FLUSH_SECONDS 1.0

static double clock_seconds(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* From now on the first flush is a second away, or less. */
static void shard_flush_schedule(struct rmap_shard_writer *self)
{
    double interval = self->options.flush_seconds;
    self->flush_due =
        clock_seconds() + (interval < FIRST_FLUSH_SECONDS ? interval : FIRST_FLUSH_SECONDS);
}

/* Whether anything was appended that no flush has taken. Under the lock. */
static bool shard_flush_has_new(const struct rmap_shard_writer *self)
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

/* Puts the sign for a flush into the queue, if anything is new and none is pending. Under the
 * lock. RMAP_SYSTEM: memory. */
static enum rmap_status shard_flush_begin(struct rmap_shard_writer *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_flush *flush = &self->flush;
    struct rmap_shard_piece *piece = self->piece;
    struct rmap_chunk *sign = NULL;
    if (flush->pending || !shard_flush_has_new(self))
        return RMAP_OK;
    RMAP_TRY(rmap_chunk_queue_take(&self->queue, RMAP_STREAM_MAX, &sign, err));
    flush->batch.nbytes = 0;
    for (int s = 0; s < self->queue.layout->n_stream; s++)
        if (self->open[s])
            RMAP_TRY(take_rows(self, s, err));
    RMAP_TRY(rmap_journal_add_portions(&flush->batch, rmap_scene_keeps_curves(self->run.scene),
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

/* Begins a flush when it is time. Under the lock; the writing thread. */
static enum rmap_status shard_flush_when_due(struct rmap_shard_writer *self, struct rmap_error *err)
{
    const struct rmap_shard_options *options = &self->options;
    if (self->flush.pending || !shard_flush_has_new(self))
        return RMAP_OK;
    uint64_t n_new = self->piece->n_portion - self->piece->n_portion_taken;
    double now = clock_seconds();
    bool by_time = options->flush_seconds > 0 && now >= self->flush_due;
    if (!by_time && (options->flush_portions == 0 || n_new < options->flush_portions))
        return RMAP_OK;
    self->flush_due = now + options->flush_seconds;
    return shard_flush_begin(self, err);
}

static const struct rmap_shard_options defaults = {.piece_nbytes = (size_t)512 << 20,
                                                   .flush_seconds = RMAP_FLUSH_SECONDS};

static void piece_destroy(struct rmap_shard_piece *piece)
{
    if (!piece)
        return;
    rmap_path_book_destroy(piece->book);
    rmap_free(piece->portion);
    rmap_free(piece);
}

/* A folder in which a piece is known stands, and was synced before it. */
static enum rmap_status open_folder(struct rmap_shard_writer *self, const char *directory,
                                    struct rmap_error *err)
{
    self->next_number = self->options.first_piece;
    if (self->next_number > 0)
        return RMAP_OK;
    const bool made = mkdir(self->path, 0777) == 0;
    if (!made && errno != EEXIST)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot make the directory: %s", self->path,
                              strerror(errno));
    enum rmap_status st = rmap_sync_directory(directory, err);
    if (st == RMAP_OK && !made)
        st = rmap_shard_next_piece(self->path, &self->next_number, err);
    return st;
}

enum rmap_status rmap_shard_writer_create(const char *directory, int shard,
                                          const struct rmap_run *run,
                                          const struct rmap_shard_options *options,
                                          struct rmap_shard_writer **writer_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_writer *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a shard");
    (void)pthread_mutex_init(&self->lock, NULL);
    self->shard = shard;
    self->run = *run;
    self->options = options ? *options : defaults;
    if (self->options.piece_nbytes == 0)
        self->options.piece_nbytes = defaults.piece_nbytes;
    self->queue.n_channel = run->scene->channels.n;
    self->queue.layout = rmap_layout_of(run->encoding, run->scene->channels.mode);
    self->path = rmap_path_format("%s/shard-%05d", directory, shard);
    if (!self->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a shard");
        goto out;
    }
    RMAP_TRY(rmap_row_pool_create(run, &self->rows, err));
    RMAP_TRY(open_folder(self, directory, err));
    if (self->options.origin)
        self->origin = *self->options.origin;
    else
        RMAP_TRY(rmap_piece_origin_of(run, &self->origin, err));
    shard_flush_schedule(self);
    *writer_ret = self;
    self = NULL;
out:
    rmap_shard_writer_destroy(self);
    return st;
}

enum rmap_status rmap_shard_leave(struct rmap_shard_writer *self, enum rmap_status st,
                                  const struct rmap_error *err)
{
    if (st != RMAP_OK && self->failed == RMAP_OK) {
        self->failed = st;
        if (err)
            self->cause = *err;
    }
    atomic_store_explicit(&self->backlog, self->queue.nbytes, memory_order_relaxed);
    (void)pthread_mutex_unlock(&self->lock);
    return st;
}

enum rmap_status rmap_shard_enter(struct rmap_shard_writer *self, struct rmap_error *err)
{
    (void)pthread_mutex_lock(&self->lock);
    if (self->failed == RMAP_OK)
        return RMAP_OK;
    const struct rmap_error cause = self->cause;
    enum rmap_status st = self->failed;
    (void)pthread_mutex_unlock(&self->lock);
    return rmap_error_set(err, st, "%s",
                          cause.text[0] ? cause.text : "a shard could not be written");
}

/* An idle encoder or a new one; called under the lock. */
static enum rmap_status take_encoder(struct rmap_shard_writer *self,
                                     struct rmap_encoder_slot **slot_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_encoder_slot *slot = self->idle;
    if (slot) {
        self->idle = slot->next;
    } else {
        slot = rmap_alloc(1, sizeof *slot);
        if (!slot)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
        st = rmap_encoder_create(&slot->encoder, err);
        if (st != RMAP_OK) {
            rmap_free(slot);
            return st;
        }
    }
    *slot_ret = slot;
    return st;
}

static enum rmap_status encode_chunk(const struct rmap_layout *layout,
                                     struct rmap_encoder_slot *slot, struct rmap_chunk *chunk,
                                     struct rmap_error *err)
{
    const struct rmap_stream_info *stream = &layout->stream[chunk->stream];
    size_t element = rmap_element_nbytes(stream->element);
    size_t n = chunk->raw_nbytes / element;
    if (!chunk->stored)
        chunk->stored = rmap_alloc_unset(rmap_codec_bound(n, element), 1);
    if (!chunk->stored)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoded chunk");
    size_t n_used = n / RMAP_CHUNK_ROWS * chunk->n_row;
    for (size_t k = 0; k < element; k++)
        memset(chunk->plane + k * n + n_used, 0, n - n_used);
    const unsigned how = (layout->run_tables >> stream->table & 1 ? RMAP_ENCODE_RUNS : 0) |
                         (layout->quick_streams >> chunk->stream & 1 ? RMAP_ENCODE_QUICK : 0);
    chunk->stored_nbytes =
        rmap_encoder_encode_planes(slot->encoder, chunk->plane, n, element, how, chunk->stored);
    return RMAP_OK;
}

enum rmap_status rmap_shard_writer_encode(struct rmap_shard_writer *self, bool *did_ret,
                                          struct rmap_error *err)
{
    struct rmap_encoder_slot *slot = NULL;
    struct rmap_chunk *chunk = NULL;
    *did_ret = false;
    enum rmap_status st = rmap_shard_enter(self, err);
    if (st != RMAP_OK)
        return st;
    if (self->queue.unencoded)
        st = take_encoder(self, &slot, err);
    if (slot)
        chunk = rmap_chunk_queue_next(&self->queue);
    st = rmap_shard_leave(self, st, err);
    if (!slot)
        return st;

    st = encode_chunk(self->queue.layout, slot, chunk, err);

    (void)pthread_mutex_lock(&self->lock);
    slot->next = self->idle;
    self->idle = slot;
    rmap_chunk_queue_encoded(&self->queue, chunk);
    *did_ret = st == RMAP_OK;
    return rmap_shard_leave(self, st, err);
}

static enum rmap_status finish_piece(struct rmap_shard_writer *self,
                                     const struct rmap_shard_piece *piece, struct rmap_error *err)
{
    const struct rmap_path_sum *path = piece->book ? rmap_path_book_sums(piece->book) : NULL;
    enum rmap_status st = rmap_piece_writer_finish(self->file, piece->portion, piece->n_portion,
                                                   piece->stored_rows, path, &self->content, err);
    if (st != RMAP_OK)
        return st;
    rmap_piece_writer_destroy(self->file);
    self->file = NULL;
    return st;
}

static enum rmap_status store_chunk(struct rmap_shard_writer *self, const struct rmap_chunk *chunk,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->file)
        RMAP_TRY(rmap_piece_writer_create(self->path, self->shard, chunk->piece->number, &self->run,
                                          &self->origin, &self->file, err));
    switch (chunk->sign) {
    case RMAP_SIGN_END_PIECE:
        return finish_piece(self, chunk->piece, err);
    case RMAP_SIGN_FLUSH:
        return rmap_piece_writer_flush(self->file, &self->flush.batch, self->flush.stored_rows,
                                       self->flush.n_portion, err);
    case RMAP_SIGN_NONE:
        return rmap_piece_writer_put(self->file, chunk->stream, chunk->index, chunk->n_row_end,
                                     chunk->stored, chunk->stored_nbytes, err);
    }
out:
    return st;
}

/* Under the lock. */
static void release_chunk(struct rmap_shard_writer *self, struct rmap_chunk *chunk)
{
    if (chunk->sign == RMAP_SIGN_END_PIECE)
        piece_destroy(chunk->piece);
    if (chunk->sign == RMAP_SIGN_FLUSH) {
        self->flush.pending = false;
        self->flush.n_done++;
    }
    rmap_chunk_queue_give_back(&self->queue, chunk);
}

enum rmap_status rmap_shard_writer_store(struct rmap_shard_writer *self, struct rmap_error *err)
{
    enum rmap_status st = rmap_shard_enter(self, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_chunk *chunk;
    st = shard_flush_when_due(self, err);
    /* A chunk that another thread failed to encode must not end up in a published piece. */
    while (st == RMAP_OK && self->failed == RMAP_OK &&
           (chunk = rmap_chunk_queue_pop(&self->queue))) {
        (void)pthread_mutex_unlock(&self->lock);
        st = store_chunk(self, chunk, err);
        (void)pthread_mutex_lock(&self->lock);
        release_chunk(self, chunk);
    }
    return rmap_shard_leave(self, st, err);
}

/* Asks for a flush unless one is pending, whose rows are older than the call; *asked_ret is true
 * once it is asked for or nothing is left to flush. */
static enum rmap_status ask_flush(struct rmap_shard_writer *self, bool *asked_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = rmap_shard_enter(self, err);
    if (st != RMAP_OK)
        return st;
    *asked_ret = !self->flush.pending;
    if (*asked_ret)
        st = shard_flush_begin(self, err);
    return rmap_shard_leave(self, st, err);
}

/* A flush, or a piece that is to be published. */
static bool flush_pending(struct rmap_shard_writer *self)
{
    (void)pthread_mutex_lock(&self->lock);
    bool pending = self->flush.pending;
    for (const struct rmap_chunk *chunk = self->queue.head; chunk; chunk = chunk->next)
        pending |= chunk->sign == RMAP_SIGN_END_PIECE;
    (void)pthread_mutex_unlock(&self->lock);
    return pending;
}

enum rmap_status rmap_shard_writer_flush(struct rmap_shard_writer *self, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 1000000};
    enum rmap_status st = RMAP_OK;
    bool asked = false, did;
    while (!asked || flush_pending(self)) {
        if (!asked)
            RMAP_TRY(ask_flush(self, &asked, err));
        RMAP_TRY(rmap_shard_writer_encode(self, &did, err));
        RMAP_TRY(rmap_shard_writer_store(self, err));
        if (!did && flush_pending(self))
            (void)nanosleep(&nap, NULL); /* others encode the rest */
    }
out:
    return st;
}

size_t rmap_shard_writer_backlog(const struct rmap_shard_writer *self)
{
    return atomic_load_explicit(&self->backlog, memory_order_relaxed);
}

enum rmap_status rmap_shard_writer_end(struct rmap_shard_writer *self, struct rmap_error *err)
{
    enum rmap_status st = rmap_shard_enter(self, err);
    if (st != RMAP_OK)
        return st;
    if (self->piece)
        st = rmap_shard_end_piece(self, err);
    return rmap_shard_leave(self, st, err);
}

enum rmap_status rmap_shard_writer_finish(struct rmap_shard_writer *self, struct rmap_error *err)
{
    enum rmap_status st = rmap_shard_writer_end(self, err);
    for (bool did = true; did && st == RMAP_OK;) {
        st = rmap_shard_writer_encode(self, &did, err);
        if (st == RMAP_OK)
            st = rmap_shard_writer_store(self, err);
    }
    return st;
}

uint64_t rmap_shard_writer_flushes(const struct rmap_shard_writer *self)
{
    return self->flush.n_done;
}

const struct rmap_map_content *rmap_shard_writer_content(const struct rmap_shard_writer *self)
{
    return &self->content;
}

void rmap_shard_writer_destroy(struct rmap_shard_writer *self)
{
    if (!self)
        return;
    rmap_piece_writer_destroy(self->file);
    for (struct rmap_chunk *chunk = self->queue.head; chunk; chunk = chunk->next)
        if (chunk->sign == RMAP_SIGN_END_PIECE)
            piece_destroy(chunk->piece);
    piece_destroy(self->piece);
    rmap_journal_batch_fini(&self->flush.batch);
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_chunk_destroy(self->open[s]);
    rmap_map_content_fini(&self->content);
    rmap_row_pool_destroy(self->rows);
    rmap_chunk_queue_fini(&self->queue);
    for (struct rmap_encoder_slot *slot = self->idle, *next; slot; slot = next) {
        next = slot->next;
        rmap_encoder_destroy(slot->encoder);
        rmap_free(slot);
    }
    (void)pthread_mutex_destroy(&self->lock);
    rmap_free(self->path);
    rmap_free(self);
}
