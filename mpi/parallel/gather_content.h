/* SPDX-License-Identifier: MIT
 *
 * What every rank's writer published, on rank 0: the index is made of it, and no rank looks at
 * another's disk.
 */
#ifndef RMAP_GATHER_CONTENT_H
#define RMAP_GATHER_CONTENT_H

#include "base/status.h"
#include "io/map/map_content.h"
#include "mpi/parallel/context.h"

/* Collective. Appends the pieces of every rank's `mine` (NULL: none; without tails) to rank 0's
 * content, in the order of ranks. */
enum rmap_status rmap_gather_content(const struct rmap_context *context,
                                     const struct rmap_map_content *mine,
                                     struct rmap_map_content *content,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
