/* SPDX-License-Identifier: MIT
 *
 * The files of a map in its directory: NAME.raymap/map.h5, shard-RRRRR/piece-KKKKK.h5, and what
 * unfinished writers left: shard-RRRRR/.piece-KKKKK.h5.*.part with its .journal.
 */
#ifndef RMAP_MAP_DIRECTORY_H
#define RMAP_MAP_DIRECTORY_H

#include "io/map/map_lock.h"
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* Smallest number that no piece in the directory has, and none above it. */
enum rmap_status rmap_shard_next_piece(const char *shard_path, int *number_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Before anything is made or removed for a run that writes its shard elsewhere than in the map's
 * directory. RMAP_USAGE: is_new, of a new map, and the shard's folder there is a link, or holds
 * files, which are another map's. RMAP_SYSTEM: there is no `directory`, or no writing in it. */
enum rmap_status rmap_shard_check_place(const char *directory, int shard, bool is_new,
                                        struct rmap_error *err) RMAP_MUST_USE;

struct rmap_piece_name {
    int shard, number;
};

/* An unfinished piece: of a dead writer or of one at work. */
struct rmap_leftover {
    int shard;
    char name[288]; /* "shard-00000/.piece-00000.h5.JOB.RESTART.HOST.PID.part" */
    bool has_part, has_journal;
};

struct rmap_piece_list {
    struct rmap_piece_name *name; /* by shard and number */
    size_t n, cap;
};

/* What one look at a map's directory and at the folders of its shards found. Many files in many
 * folders are a load for a cluster's file system: who needs more than one kind looks once. */
struct rmap_map_listing {
    struct rmap_piece_list pieces;    /* published */
    struct rmap_piece_list histories; /* old history indexes, by their pieces */
    struct rmap_piece_list columns;   /* kept columns, likewise */
    struct rmap_leftover *leftover;   /* by name */
    size_t n_leftover, cap_leftover;
    struct rmap_leftover *half; /* what killed runs left of an index, or of named rays */
    size_t n_half, cap_half;
    struct rmap_error link; /* where a shard's folder is a link: that it was passed over; or "" */
};

/* RMAP_SYSTEM: a folder cannot be listed; the listing is empty then. */
enum rmap_status rmap_map_list(const char *map_path, struct rmap_map_listing *listing,
                               struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_listing_fini(struct rmap_map_listing *listing);

/* All published pieces alone. *name_ret: rmap_free. */
enum rmap_status rmap_map_list_pieces(const char *map_path, struct rmap_piece_name **name_ret,
                                      size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Likewise history indexes of earlier versions, by shard and number of their pieces. */
#define RMAP_HISTORY_SUFFIX ".history.h5" /* in place of ".h5" of its piece */
enum rmap_status rmap_map_list_histories(const char *map_path, struct rmap_piece_name **name_ret,
                                         size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Removes what killed runs left of an index, or of named rays, that they were writing. */
enum rmap_status rmap_map_remove_half_indexes(const char *map_path,
                                              struct rmap_error *err) RMAP_MUST_USE;

/* Of pieces that are finished: removing them need not have lasted when the power failed. Those that
 * cannot be removed do no harm. For complete maps alone: all that journals told is in the index. */
enum rmap_status rmap_map_remove_spent_journals(const char *map_path,
                                                const struct rmap_map_listing *found,
                                                struct rmap_error *err) RMAP_MUST_USE;

/* Sorted by name. *leftover_ret: rmap_free. */
enum rmap_status rmap_map_list_leftovers(const char *map_path, struct rmap_leftover **leftover_ret,
                                         size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Of a directory without map.h5: RMAP_FORMAT, and what to do, when pieces or journals of unfinished
 * ones say that there was one. */
enum rmap_status rmap_map_check_indexless(const char *map_path,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Whether its writer is at work: one of its files is locked then (io/file/file_lock.h). False where
 * the file system keeps no locks, or memory is short; and whether one of the map's writers is. */
bool rmap_map_is_live(const char *map_path);

/* RMAP_USAGE when a shard's folder is a link, or when a writer of the map is still at work after a
 * moment: those that are being killed are given time to go. What they left of an index is removed,
 * for the caller has the map's lock. What else stood there then is in *found,
 * which is empty after an error. */
enum rmap_status rmap_map_await_writers(const char *map_path, struct rmap_map_listing *found,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Of the journal that goes with a .part file; rmap_free. NULL when memory is short. */
char *rmap_journal_path(const char *part_path);

/* Makes the directory NAME.raymap. RMAP_USAGE when it exists (and force is false; force removes a
 * ray map that stands there, and nothing else), RMAP_SYSTEM when it cannot be made. The caller
 * has the lock from here on, if not before, and releases it; `command` as in io/map/map_lock.h.
 * NULL: for whoever has the map to himself. */
enum rmap_status rmap_map_create(const char *path, bool force, const char *command,
                                 struct rmap_map_lock *lock, struct rmap_error *err) RMAP_MUST_USE;

/* Takes a map away again whose making failed; what is no part of a map stays, and is an error. */
enum rmap_status rmap_map_remove(const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
