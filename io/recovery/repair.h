/* SPDX-License-Identifier: MIT
 *
 * Steps that bring a damaged map back to a whole one of the rays that are left. Each leaves, at
 * every moment, a map that holds no less than before it: new files are published before old ones
 * go, and rays that stand twice count once. One process does them, after a verification.
 */
#ifndef RMAP_REPAIR_H
#define RMAP_REPAIR_H

#include "io/map/map_writer.h"
#include "io/recovery/verify.h"

/* Replaces map.h5 by one without rays, incomplete, so that pieces and journals on disk are what the
 * map holds. Its scene, runs and spaces come from map.h5 itself, else, or where that knows of later
 * runs, from map-start.h5, else from `scene` (its bundle and scene; NULL: not given), which must be
 * the one that the pieces name.
 * *done: appended to, what was done. RMAP_INPUT: no scene is to be had, or it is another one. */
enum rmap_status rmap_repair_index(const char *path, const struct rmap_run *scene,
                                   struct rmap_findings *done,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Whether piece `piece` of the verification is to be replaced by one with what is good of it. */
bool rmap_repair_replaces(const struct rmap_verification *verification, size_t piece);

/* Smallest number above those of all shards on disk. */
enum rmap_status rmap_repair_free_shard(const char *path, int *shard_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Writes the index of all finished pieces of the verification's map but the replaced ones, and of
 * `copied`. tally: of their rays. */
enum rmap_status rmap_repair_write(const struct rmap_verification *verification,
                                   const struct rmap_map_content *copied,
                                   const struct rmap_tally *tally, bool complete,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Then removes the files of pieces that were replaced, that are damaged, and those all of whose
 * rays the index has from others. Pieces of another scene, seed or version stay. */
enum rmap_status rmap_repair_remove(const struct rmap_verification *verification,
                                    struct rmap_findings *done,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Removes history indexes, which earlier versions made. */
enum rmap_status rmap_repair_remove_histories(const char *map_path, struct rmap_findings *done,
                                              struct rmap_error *err) RMAP_MUST_USE;

/* Removes a leftover that nothing can be read of. */
enum rmap_status rmap_repair_remove_leftover(const char *path, const char *name,
                                             struct rmap_findings *done,
                                             struct rmap_error *err) RMAP_MUST_USE;

#endif
