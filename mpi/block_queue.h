/* SPDX-License-Identifier: MIT
 *
 * Block numbers on their way from the thread that talks MPI to the workers of its rank.
 */
#ifndef RMAP_BLOCK_QUEUE_H
#define RMAP_BLOCK_QUEUE_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_block_queue {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    uint64_t *block; /* ring [cap] */
    size_t cap, first, n;
    bool closed;
};

enum rmap_status rmap_block_queue_init(struct rmap_block_queue *queue, size_t cap,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_block_queue_fini(struct rmap_block_queue *queue);

/* At most cap numbers may be in the queue. */
void rmap_block_queue_push(struct rmap_block_queue *queue, uint64_t block);

/* No more will come; `discard` drops those that nobody took. A queue never begun is fine. */
void rmap_block_queue_close(struct rmap_block_queue *queue);
void rmap_block_queue_discard(struct rmap_block_queue *queue);

/* Waits for a number; false when there is none and none will come. */
bool rmap_block_queue_pop(struct rmap_block_queue *queue, uint64_t *block_ret);

size_t rmap_block_queue_length(struct rmap_block_queue *queue);

#endif
