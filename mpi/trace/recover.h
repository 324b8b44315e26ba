/* SPDX-License-Identifier: MIT
 *
 * Finishing what killed writers of a map left, on all ranks.
 */
#ifndef RMAP_RECOVER_H
#define RMAP_RECOVER_H

#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "mpi/command/command.h"

/* Collective. Gives writers that are being killed a moment to go; to be called before the map is
 * opened. *found: what rank 0 saw then (rmap_map_listing_fini); empty on the others. RMAP_USAGE: a
 * writer is still at work. */
enum rmap_status rmap_recover_wait(const struct rmap_context *context, const char *map_path,
                                   struct rmap_map_listing *found,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Rank 0's list of unfinished pieces, on every rank. *list_ret: rmap_free. */
enum rmap_status rmap_recover_list(const struct rmap_context *context, const char *map_path,
                                   struct rmap_leftover **list_ret, size_t *n_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Each unfinished piece that rank 0 found, and that the map has as such, is made a
 * finished one by one of the ranks, which takes its place in the map. Rank 0 tells what was
 * recovered and what was damaged. RMAP_SYSTEM: memory, disk. */
enum rmap_status rmap_recover(const struct rmap_context *context, struct rmap_map *map,
                              struct rmap_map_listing *found, struct rmap_error *err) RMAP_MUST_USE;

#endif
