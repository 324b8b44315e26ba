/* SPDX-License-Identifier: MIT
 *
 * Handing out numbers (of blocks of rays, of tiles) to ranks: each asks rank 0 for some before
 * those that it has run out, and gets them in proportion to what is left, so that a fast rank
 * simply takes more of them. Plain messages, as every way to send that MPI has, on one node or
 * many, knows them; one question of a rank is under way at a time.
 *
 * The thread that talks MPI calls rmap_blocks_serve often; no call waits.
 */
#ifndef RMAP_BLOCKS_H
#define RMAP_BLOCKS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_blocks;

/* Collective. n_block numbers, from 0. */
enum rmap_status rmap_blocks_create(const struct rmap_context *context, uint64_t n_block,
                                    struct rmap_blocks **blocks_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_blocks_destroy(struct rmap_blocks *blocks); /* Collective. NULL is fine. */

/* Not collective. Asks for up to n_wanted numbers (0: none) unless a question is under way, and
 * tells rank 0 what this rank has done, in any unit, now and then in any case. Rank 0 answers. */
enum rmap_status rmap_blocks_serve(struct rmap_blocks *blocks, uint64_t n_wanted, uint64_t n_done,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The next number of those that came; false: none is here now. */
bool rmap_blocks_take(struct rmap_blocks *blocks, uint64_t *number_ret);
uint64_t rmap_blocks_at_hand(const struct rmap_blocks *blocks);

/* None is here, and none will come. */
bool rmap_blocks_ended(const struct rmap_blocks *blocks);

/* No rank gets another number: said on any rank, and heard by all after a moment of serving. */
void rmap_blocks_stop(struct rmap_blocks *blocks);
bool rmap_blocks_stopped(const struct rmap_blocks *blocks);

/* On rank 0: what all ranks have done, as far as they told. */
uint64_t rmap_blocks_done(const struct rmap_blocks *blocks);

/* Collective. Waits for all ranks and leaves the cores to those that still work. `serve` is called
 * meanwhile: it serves whatever this rank has to. */
enum rmap_status
rmap_blocks_wait_for_all(const struct rmap_context *context, struct rmap_blocks *const *blocks,
                         size_t n, enum rmap_status (*serve)(void *self, struct rmap_error *err),
                         void *self, struct rmap_error *err) RMAP_MUST_USE;

#endif
