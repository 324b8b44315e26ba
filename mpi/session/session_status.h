/* SPDX-License-Identifier: MIT
 *
 * How much of its map a session keeps in memory.
 */
#ifndef RMAP_SESSION_STATUS_H
#define RMAP_SESSION_STATUS_H

#include "io/map/map_reader.h"
#include "mpi/command/command.h"

/* Collective. Rank 0 tells what all ranks keep together. */
enum rmap_status rmap_session_status(const struct rmap_context *context, const struct rmap_map *map,
                                     uint64_t memory, struct rmap_error *err) RMAP_MUST_USE;

#endif
