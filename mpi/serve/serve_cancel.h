/* SPDX-License-Identifier: MIT
 *
 * A request that is cancelled on rank 0 stops on all ranks: a thread of each hears of it, whatever
 * its main thread computes or waits for.
 */
#ifndef RMAP_SERVE_CANCEL_H
#define RMAP_SERVE_CANCEL_H

#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_serve_cancel;

/* Collective. NULL on one rank alone and where MPI lets no threads talk; all functions here take
 * it. */
enum rmap_status rmap_serve_cancel_start(const struct rmap_context *context,
                                         struct rmap_serve_cancel **cancel_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_serve_cancel_finish(struct rmap_serve_cancel *cancel); /* Collective. */

/* About each request, in the same order on every rank. Between the two
 * rmap_interrupt_stops_question is true on every rank soon after it is on rank 0. */
void rmap_serve_cancel_begin(struct rmap_serve_cancel *cancel);
void rmap_serve_cancel_end(struct rmap_serve_cancel *cancel);

#endif
