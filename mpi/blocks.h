/* SPDX-License-Identifier: MIT
 *
 * Handing out blocks of ray ids: a counter in rank 0's memory that every rank takes the next
 * number from (MPI one-sided), so that a fast rank simply takes more of them.
 *
 * Rank 0's MPI must get a chance to answer while it traces: it calls rmap_blocks_poll often.
 */
#ifndef RMAP_BLOCKS_H
#define RMAP_BLOCKS_H

#include "mpi/command.h"

struct rmap_blocks;

/* Collective. n_block numbers, from 0. */
enum rmap_status rmap_blocks_create(const struct rmap_context *context, uint64_t n_block,
                                    struct rmap_blocks **blocks_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_blocks_destroy(struct rmap_blocks *blocks); /* Collective. NULL is fine. */

/* Not collective: the next number; n_block when there is none left. */
enum rmap_status rmap_blocks_next(struct rmap_blocks *blocks, uint64_t *block_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Not collective: no rank gets another number. */
enum rmap_status rmap_blocks_stop(struct rmap_blocks *blocks, struct rmap_error *err) RMAP_MUST_USE;

/* Not collective: whether a rank has stopped the handing out. */
enum rmap_status rmap_blocks_stopped(struct rmap_blocks *blocks, bool *stopped_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Not collective: how many were handed out, to any rank. Lets MPI make progress. */
enum rmap_status rmap_blocks_poll(struct rmap_blocks *blocks, uint64_t *handed_out_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
