/* SPDX-License-Identifier: MIT
 *
 * Work on its way from the thread that talks MPI to the workers of its rank.
 */
#include "mpi/parallel/block_queue.h"

#include <time.h>

#include "base/alloc.h"

enum rmap_status rmap_block_queue_init(struct rmap_block_queue *queue, size_t cap,
                                       struct rmap_error *err)
{
    pthread_condattr_t steady;
    *queue = (struct rmap_block_queue){.cap = cap};
    queue->item = rmap_alloc(cap, sizeof *queue->item);
    if (!queue->item)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    (void)pthread_mutex_init(&queue->mutex, NULL);
    (void)pthread_cond_init(&queue->changed, NULL);
    (void)pthread_condattr_init(&steady);
    (void)pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    (void)pthread_cond_init(&queue->hungry, &steady);
    (void)pthread_condattr_destroy(&steady);
    return RMAP_OK;
}

void rmap_block_queue_fini(struct rmap_block_queue *queue)
{
    if (!queue->item)
        return;
    rmap_block_queue_discard(queue);
    (void)pthread_mutex_destroy(&queue->mutex);
    (void)pthread_cond_destroy(&queue->changed);
    (void)pthread_cond_destroy(&queue->hungry);
    rmap_free(queue->item);
    queue->item = NULL;
}

void rmap_block_queue_push(struct rmap_block_queue *queue, struct rmap_work_item item)
{
    (void)pthread_mutex_lock(&queue->mutex);
    queue->item[(queue->first + queue->n++) % queue->cap] = item;
    (void)pthread_cond_signal(&queue->changed);
    (void)pthread_mutex_unlock(&queue->mutex);
}

void rmap_block_queue_close(struct rmap_block_queue *queue)
{
    if (!queue->item)
        return;
    (void)pthread_mutex_lock(&queue->mutex);
    queue->closed = true;
    (void)pthread_cond_broadcast(&queue->changed);
    (void)pthread_mutex_unlock(&queue->mutex);
}

void rmap_block_queue_discard(struct rmap_block_queue *queue)
{
    (void)pthread_mutex_lock(&queue->mutex);
    for (; queue->n > 0; queue->n--) {
        rmap_message_destroy(queue->item[queue->first].message);
        queue->first = (queue->first + 1) % queue->cap;
    }
    (void)pthread_mutex_unlock(&queue->mutex);
}

bool rmap_block_queue_pop(struct rmap_block_queue *queue, struct rmap_work_item *item_ret)
{
    (void)pthread_mutex_lock(&queue->mutex);
    while (queue->n == 0 && !queue->closed)
        (void)pthread_cond_wait(&queue->changed, &queue->mutex);
    bool found = queue->n > 0;
    if (found) {
        *item_ret = queue->item[queue->first];
        queue->first = (queue->first + 1) % queue->cap;
        if (--queue->n < queue->low)
            (void)pthread_cond_signal(&queue->hungry);
    }
    (void)pthread_mutex_unlock(&queue->mutex);
    return found;
}

void rmap_block_queue_rest(struct rmap_block_queue *queue, size_t low, int milliseconds)
{
    const long second_ns = 1000000000;
    struct timespec until = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += milliseconds * 1000000L;
    until.tv_sec += until.tv_nsec / second_ns;
    until.tv_nsec %= second_ns;
    (void)pthread_mutex_lock(&queue->mutex);
    queue->low = low;
    while (queue->n >= low && !queue->knocked &&
           pthread_cond_timedwait(&queue->hungry, &queue->mutex, &until) == 0)
        continue;
    queue->low = 0;
    queue->knocked = false;
    (void)pthread_mutex_unlock(&queue->mutex);
}

void rmap_block_queue_knock(struct rmap_block_queue *queue)
{
    (void)pthread_mutex_lock(&queue->mutex);
    queue->knocked = true;
    (void)pthread_cond_signal(&queue->hungry);
    (void)pthread_mutex_unlock(&queue->mutex);
}

size_t rmap_block_queue_length(struct rmap_block_queue *queue)
{
    (void)pthread_mutex_lock(&queue->mutex);
    size_t n = queue->n;
    (void)pthread_mutex_unlock(&queue->mutex);
    return n;
}
