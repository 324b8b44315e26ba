/* SPDX-License-Identifier: MIT
 *
 * The worker threads of one rank while it traces.
 */
#ifndef RMAP_TRACE_WORKERS_H
#define RMAP_TRACE_WORKERS_H

#include "mpi/parallel/block_queue.h"
#include "mpi/trace/trace_run.h"

struct rmap_trace_workers;

/* Starts n_thread workers that take blocks of `rays` from the queue until it is closed and empty.
 * Plan, rays and queue are borrowed. */
enum rmap_status rmap_trace_workers_start(const struct rmap_trace_plan *plan,
                                          const struct rmap_ray_plan *rays, int n_thread,
                                          struct rmap_block_queue *queue,
                                          struct rmap_trace_workers **workers_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

bool rmap_trace_workers_done(const struct rmap_trace_workers *workers);
bool rmap_trace_workers_failed(const struct rmap_trace_workers *workers);

/* Makes the workers return at their next look; what they have begun is lost. */
void rmap_trace_workers_abandon(struct rmap_trace_workers *workers);

/* Ends every block after the ray in hand: the rays until there are kept, the others are not traced,
 * nor those of blocks that wait. Other work is finished. */
void rmap_trace_workers_leave(struct rmap_trace_workers *workers);

/* Rays traced so far. */
uint64_t rmap_trace_workers_traced(const struct rmap_trace_workers *workers);

/* Of them, those that were taken over of an older map; once they are joined. */
uint64_t rmap_trace_workers_reused(const struct rmap_trace_workers *workers);

/* Seconds that a block took of late; 0 before the first. */
double rmap_trace_workers_pace(const struct rmap_trace_workers *workers);

/* Waits for the workers. Then: sums of all of them (caller destroys the tally), rays traced, and
 * the first worker's error. */
enum rmap_status rmap_trace_workers_join(struct rmap_trace_workers *workers,
                                         struct rmap_tally **tally_ret, uint64_t *n_ray_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
/* After the workers: the chunks that are left, by n_thread threads, this one among them. */
enum rmap_status rmap_trace_encode_rest(struct rmap_shard_writer *writer, int n_thread,
                                        struct rmap_error *err) RMAP_MUST_USE;

void rmap_trace_workers_destroy(struct rmap_trace_workers *workers); /* waits too; NULL is fine */

#endif
