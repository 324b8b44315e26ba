/* SPDX-License-Identifier: MIT
 *
 * Walking through a directory whose files have numbered names; and the folder of a shard, which is
 * one in the map's directory: what stands there as a link may lead into another map, and nothing is
 * listed, written or removed through it.
 */
#ifndef RMAP_DIRECTORY_H
#define RMAP_DIRECTORY_H

#include <stddef.h>
#include <sys/stat.h>

#include "base/status.h"

/* Numbers of shards and pieces have five digits. */
#define RMAP_NUMBER_END 100000

/* The number in "prefixNNNNNsuffix", or -1. */
int rmap_directory_number(const char *name, const char *prefix, const char *suffix);

/* What stands at a path, 0 of info->st_mode where nothing does. RMAP_SYSTEM: nobody can tell now,
 * and it may not be taken for missing. */
enum rmap_status rmap_path_look(const char *path, struct stat *info,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The folder, unless it is there. RMAP_USAGE: something else stands there. */
enum rmap_status rmap_folder_make(const char *folder, struct rmap_error *err) RMAP_MUST_USE;

/* The same with the folders above it. *had: length of the part of the name that was there before,
 * for rmap_folder_unmake, which removes the others where nothing is in them. */
enum rmap_status rmap_folder_make_all(const char *folder, size_t *had,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_folder_unmake(const char *folder, size_t had);

/* directory: that of the entry, for *at functions. */
typedef enum rmap_status rmap_directory_visitor(void *context, int directory, const char *name,
                                                struct rmap_error *err);

/* Calls visit for every entry but . and .. until it fails. RMAP_SYSTEM, or what visit says. */
enum rmap_status rmap_directory_visit(const char *path, rmap_directory_visitor *visit,
                                      void *context, struct rmap_error *err) RMAP_MUST_USE;

/* A descriptor of a shard's folder, for the caller to close: the last part of `path` in the
 * directory `map`, or all of it where that is AT_FDCWD. RMAP_USAGE: no folder, or a link. */
enum rmap_status rmap_shard_open(int map, const char *path, int *fd_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The same as rmap_directory_visit in a shard's folder, found as above. */
enum rmap_status rmap_shard_visit(int map, const char *path, rmap_directory_visitor *visit,
                                  void *context, struct rmap_error *err) RMAP_MUST_USE;

/* Removes ".../shard-NNNNN/NAME". 0, or -1 with errno. */
int rmap_shard_unlink(const char *path) RMAP_MUST_USE;

#endif
