/* SPDX-License-Identifier: MIT
 *
 * Rays on their way to rank 0.
 */
#ifndef RMAP_GATHER_H
#define RMAP_GATHER_H

#include "mpi/command.h"
#include "trace/portion.h"

/* Not collective. Appends all rows of src to dst, which has the same channels; both have all
 * columns. dst is unchanged when memory is short. */
enum rmap_status rmap_portion_append(struct rmap_portion *dst, const struct rmap_portion *src,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Not collective. Drops all rays but the first n. */
void rmap_portion_truncate(struct rmap_portion *portion, size_t n);

/* Collective. Appends the rows of ranks 1, 2, ... to rank 0's portion, in this order. */
enum rmap_status rmap_gather_portion(const struct rmap_context *context,
                                     struct rmap_portion *portion,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
