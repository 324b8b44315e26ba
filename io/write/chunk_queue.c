/* SPDX-License-Identifier: MIT
 *
 * Chunks on their way from the streams' buffers to the file: filled, encoded by any thread, stored
 * by one, in the order in which they were filled.
 */
#include "io/write/chunk_queue.h"

#include "base/alloc.h"

enum rmap_status rmap_chunk_queue_take(struct rmap_chunk_queue *queue, int stream,
                                       struct rmap_chunk **chunk_ret, struct rmap_error *err)
{
    struct rmap_chunk *chunk = queue->spare[stream];
    bool is_sign = stream == RMAP_STREAM_MAX;
    if (chunk) {
        queue->spare[stream] = chunk->next;
    } else {
        chunk = rmap_alloc(1, sizeof *chunk);
        if (chunk && !is_sign) {
            chunk->raw_nbytes =
                RMAP_CHUNK_ROWS *
                rmap_stream_row_nbytes(&queue->layout->stream[stream], queue->n_channel);
            chunk->plane = rmap_alloc_unset(chunk->raw_nbytes, 1);
        }
        if (!chunk || (!is_sign && !chunk->plane)) {
            rmap_free(chunk);
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for column buffers");
        }
    }
    chunk->next = NULL;
    chunk->stream = stream;
    chunk->sign = RMAP_SIGN_NONE;
    chunk->state = is_sign ? RMAP_CHUNK_ENCODED : RMAP_CHUNK_FILLED;
    chunk->n_row = 0;
    chunk->stored_nbytes = 0;
    *chunk_ret = chunk;
    return RMAP_OK;
}

static void skip_done(struct rmap_chunk_queue *queue)
{
    while (queue->unencoded && queue->unencoded->state != RMAP_CHUNK_FILLED)
        queue->unencoded = queue->unencoded->next;
}

void rmap_chunk_queue_push(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk)
{
    if (queue->tail)
        queue->tail->next = chunk;
    else
        queue->head = chunk;
    queue->tail = chunk;
    if (!queue->unencoded)
        queue->unencoded = chunk;
    skip_done(queue);
    queue->nbytes += chunk->raw_nbytes;
}

struct rmap_chunk *rmap_chunk_queue_next(struct rmap_chunk_queue *queue)
{
    struct rmap_chunk *chunk = queue->unencoded;
    if (chunk) {
        chunk->state = RMAP_CHUNK_ENCODING;
        skip_done(queue);
    }
    return chunk;
}

void rmap_chunk_queue_encoded(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk)
{
    chunk->state = RMAP_CHUNK_ENCODED;
    queue->nbytes -= chunk->raw_nbytes;
    queue->nbytes += chunk->stored_nbytes;
}

struct rmap_chunk *rmap_chunk_queue_pop(struct rmap_chunk_queue *queue)
{
    struct rmap_chunk *chunk = queue->head;
    if (!chunk || chunk->state != RMAP_CHUNK_ENCODED)
        return NULL;
    queue->head = chunk->next;
    if (!queue->head)
        queue->tail = NULL;
    queue->nbytes -= chunk->stored_nbytes;
    return chunk;
}

void rmap_chunk_queue_give_back(struct rmap_chunk_queue *queue, struct rmap_chunk *chunk)
{
    chunk->next = queue->spare[chunk->stream];
    queue->spare[chunk->stream] = chunk;
}

void rmap_chunk_destroy(struct rmap_chunk *chunk)
{
    if (!chunk)
        return;
    rmap_free(chunk->plane);
    rmap_free(chunk->stored);
    rmap_free(chunk);
}

static void destroy_list(struct rmap_chunk *chunk)
{
    while (chunk) {
        struct rmap_chunk *next = chunk->next;
        rmap_chunk_destroy(chunk);
        chunk = next;
    }
}

void rmap_chunk_queue_fini(struct rmap_chunk_queue *queue)
{
    destroy_list(queue->head);
    for (int c = 0; c <= RMAP_STREAM_MAX; c++)
        destroy_list(queue->spare[c]);
    *queue = (struct rmap_chunk_queue){0};
}
