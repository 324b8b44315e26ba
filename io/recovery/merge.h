/* SPDX-License-Identifier: MIT
 *
 * Several maps of one scene as one: their pieces are linked, not copied; the index is new.
 */
#ifndef RMAP_MERGE_H
#define RMAP_MERGE_H

#include "io/map/map_reader.h"

struct rmap_merge_source {
    const char *path;
    struct rmap_map *map; /* open; borrowed */
};

/* Whether they can be one map: same scene, seed and instruction set, no unfinished pieces, no ray
 * in two of them. RMAP_INPUT names the two and says what stands against it. n >= 1. */
enum rmap_status rmap_merge_check(const struct rmap_merge_source *source, size_t n,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Makes the map in `to`, an empty directory that exists: links every piece under a shard number of
 * its own (hard links; symbolic ones where the file systems differ, *n_symbolic_ret of them), then
 * writes the index, complete when all sources are. Killed in between it leaves an incomplete map.
 * RMAP_SYSTEM. */
enum rmap_status rmap_merge(const struct rmap_merge_source *source, size_t n, const char *to,
                            size_t *n_symbolic_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
