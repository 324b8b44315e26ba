/* SPDX-License-Identifier: MIT
 *
 * Chunks on their way from the streams' buffers to the file: filled, encoded by any thread, stored
 * by one, in the order in which they were filled. Buffers are used again. Not synchronised: the
 * shard writer holds its lock around every call here.
 */
#ifndef RMAP_CHUNK_QUEUE_H
#define RMAP_CHUNK_QUEUE_H

#include "io/codec/codec.h"
#include "io/map/map_content.h"

struct rmap_shard_piece; /* what a shard writer knows of a piece in flight */

enum rmap_chunk_state { RMAP_CHUNK_FILLED, RMAP_CHUNK_ENCODING, RMAP_CHUNK_ENCODED };

/* What the writing thread is to do when it comes to a sign: every chunk before it is stored. */
enum rmap_chunk_sign { RMAP_SIGN_NONE, RMAP_SIGN_FLUSH, RMAP_SIGN_END_PIECE };

/* A chunk, or a sign. */
struct rmap_chunk {
    struct rmap_chunk *next;
    enum rmap_chunk_state state;
    enum rmap_chunk_sign sign;
    struct rmap_shard_piece *piece;
    int stream; /* of the layout; RMAP_STREAM_MAX: a sign */
    uint32_t index;
    uint64_t n_row_end; /* rows of the stream in the piece, this chunk included */
    size_t n_row;       /* filled */
    size_t raw_nbytes;
    size_t stored_nbytes;
    uint8_t *plane;  /* [bytes of an element][raw_nbytes / that]: rows' bytes, shuffled */
    uint8_t *stored; /* [rmap_codec_bound]; made when first encoded */
};

struct rmap_chunk_queue {
    const struct rmap_layout *layout;
    int n_channel;
    struct rmap_chunk *head, *tail;
    struct rmap_chunk *unencoded;                  /* first that is not in hand or done */
    struct rmap_chunk *spare[RMAP_STREAM_MAX + 1]; /* last: signs, without buffers */
    size_t nbytes;                                 /* waiting */
};

/* A spare or new chunk for a stream, or (stream = RMAP_STREAM_MAX) a sign, which the caller sets.
 */
enum rmap_status rmap_chunk_queue_take(struct rmap_chunk_queue *queue, int stream,
                                       struct rmap_chunk **chunk_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_chunk_queue_push(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk);

/* The next chunk to encode, marked as being encoded; NULL without any. */
struct rmap_chunk *rmap_chunk_queue_next(struct rmap_chunk_queue *queue);
void rmap_chunk_queue_encoded(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk);

/* Takes the oldest chunk out if it is ready to be stored; NULL if not. */
struct rmap_chunk *rmap_chunk_queue_pop(struct rmap_chunk_queue *queue);
void rmap_chunk_queue_give_back(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk);

void rmap_chunk_destroy(struct rmap_chunk *chunk);
void rmap_chunk_queue_fini(struct rmap_chunk_queue *queue);

#endif
