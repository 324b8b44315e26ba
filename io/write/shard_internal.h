/* SPDX-License-Identifier: MIT
 *
 * A shard being written, for the files that do it.
 */
#ifndef RMAP_SHARD_INTERNAL_H
#define RMAP_SHARD_INTERNAL_H

#include <pthread.h>
#include <stdatomic.h>

#include "io/write/chunk_queue.h"
#include "io/write/piece_writer.h"
#include "io/write/row_encoder.h"

/* A piece in flight: begun by append, ended by store. */
struct rmap_shard_piece {
    int number;
    struct rmap_path_book *book; /* NULL: the encoding has none */
    uint64_t stored_rows[RMAP_STORED_TABLE_MAX];
    uint64_t raw_nbytes;
    struct rmap_portion_info *portion;
    size_t n_portion, cap_portion;
    /* That a flush has taken, so far. */
    size_t n_portion_taken;
    uint64_t rows_taken[RMAP_STREAM_MAX];
};

/* What a flush makes safe, gathered under the lock when it is asked for and written when its sign
 * comes out of the queue. One at a time. */
struct rmap_shard_flush {
    bool pending;
    uint64_t n_done;
    struct rmap_journal_batch batch;
    uint64_t stored_rows[RMAP_STORED_TABLE_MAX];
    uint64_t n_portion;
};

struct rmap_encoder_slot {
    struct rmap_encoder_slot *next;
    struct rmap_encoder *encoder;
};

struct rmap_shard_writer {
    char *path;
    int shard;
    struct rmap_run run;
    struct rmap_piece_origin origin;
    struct rmap_shard_options options;
    struct rmap_row_pool *rows;

    pthread_mutex_t lock;
    /* Under the lock. */
    enum rmap_status failed; /* RMAP_OK, or why the shard is unusable */
    struct rmap_error cause; /* told to all who come later */
    int next_number;
    struct rmap_shard_piece *piece; /* being filled, or NULL */
    struct rmap_chunk *open[RMAP_STREAM_MAX];
    struct rmap_chunk_queue queue;
    struct rmap_encoder_slot *idle;
    struct rmap_shard_flush flush;
    _Atomic size_t backlog;

    /* The writing thread's own. */
    struct rmap_piece_writer *file; /* of the piece being stored, or NULL */
    struct rmap_map_content content;
    double flush_due; /* on the monotonic clock, in seconds */
};

/* Takes the lock, unless the shard has failed: then it says why. */
enum rmap_status rmap_shard_enter(struct rmap_shard_writer *self,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Releases the lock; a failure st, reported in err (or NULL), is the shard's. Returns st. */
enum rmap_status rmap_shard_leave(struct rmap_shard_writer *self, enum rmap_status st,
                                  const struct rmap_error *err) RMAP_MUST_USE;

/* Hands over what is in the buffers, and the piece with it. Under the lock. RMAP_SYSTEM: memory. */
enum rmap_status rmap_shard_end_piece(struct rmap_shard_writer *self,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
