/* SPDX-License-Identifier: MIT
 *
 * A fold over a whole map, its portions scattered over ranks and threads.
 */
#ifndef RMAP_FOLD_RUN_H
#define RMAP_FOLD_RUN_H

#include "analysis/query/fold.h"
#include "mpi/command/command.h"

/* Collective; the fold alike on every rank. *state_ret: on rank 0 the state of all rays
 * (fold->kind->destroy), NULL on the others. Shows progress on long work. */
enum rmap_status rmap_fold_run(const struct rmap_context *context, const struct rmap_fold *fold,
                               void **state_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
