/* SPDX-License-Identifier: MIT
 *
 * Work on its way from the thread that talks MPI to the workers of its rank.
 */
#ifndef RMAP_BLOCK_QUEUE_H
#define RMAP_BLOCK_QUEUE_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mpi/parallel/message.h"

enum rmap_work {
    RMAP_WORK_TRACE,   /* block `number` of the plan */
    RMAP_WORK_RECOUNT, /* part `number` of the portions to be summed up again */
    RMAP_WORK_STORE    /* a block that another rank traced */
};

struct rmap_work_item {
    enum rmap_work work;
    uint64_t number;
    struct rmap_message *message; /* STORE: owned by whoever holds the item */
};

struct rmap_block_queue {
    pthread_mutex_t mutex;
    pthread_cond_t changed;      /* something came, or nothing will */
    pthread_cond_t hungry;       /* fewer than `low` wait, or somebody knocked */
    struct rmap_work_item *item; /* ring [cap] */
    size_t cap, first, n;
    size_t low;
    bool knocked, closed;
};

enum rmap_status rmap_block_queue_init(struct rmap_block_queue *queue, size_t cap,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_block_queue_fini(struct rmap_block_queue *queue);

/* At most cap items may be in the queue. */
void rmap_block_queue_push(struct rmap_block_queue *queue, struct rmap_work_item item);

/* No more will come; `discard` drops those that nobody took. A queue never begun is fine. */
void rmap_block_queue_close(struct rmap_block_queue *queue);
void rmap_block_queue_discard(struct rmap_block_queue *queue);

/* Waits for an item; false when there is none and none will come. */
bool rmap_block_queue_pop(struct rmap_block_queue *queue, struct rmap_work_item *item_ret);

/* For the thread that fills: waits until fewer than `low` items wait, somebody knocks, or so many
 * milliseconds have gone by. */
void rmap_block_queue_rest(struct rmap_block_queue *queue, size_t low, int milliseconds);
void rmap_block_queue_knock(struct rmap_block_queue *queue);

size_t rmap_block_queue_length(struct rmap_block_queue *queue);

#endif
