/* SPDX-License-Identifier: MIT
 *
 * An answer of nothing comes with a word on why.
 */
#ifndef RMAP_HINT_H
#define RMAP_HINT_H

#include "analysis/query/which.h"
#include "io/map/map_reader.h"
#include "mpi/command/command.h"

/* Rank 0. On stderr, where n is 0 and unless quiet: why nothing was found, where that can be told
 * without reading. */
void rmap_tell_hint(const struct rmap_context *context, const struct rmap_map *map,
                    const struct rmap_choice *choice, uint64_t n);

#endif
