/* SPDX-License-Identifier: MIT
 *
 * The sums of all ranks as one.
 */
#ifndef RMAP_TALLY_REDUCE_H
#define RMAP_TALLY_REDUCE_H

#include "base/status.h"
#include "mpi/parallel/context.h"
#include "trace/tally.h"

/* Collective. Rank 0's tally becomes the sum of all ranks', which keep their own; the first error's
 * ray is known to all. */
enum rmap_status rmap_tally_reduce(const struct rmap_context *context, struct rmap_tally *tally,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
