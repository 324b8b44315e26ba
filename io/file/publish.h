/* SPDX-License-Identifier: MIT
 *
 * Files appear under their final names whole or not at all: written under a temporary name that
 * carries job, restart count, host and process, synced, then linked without overwriting.
 */
#ifndef RMAP_PUBLISH_H
#define RMAP_PUBLISH_H

#include <stdbool.h>

#include "base/status.h"

/* "directory/name" made from a format; rmap_free. NULL when memory is short. */
char *rmap_path_format(const char *format, ...) RMAP_PRINTF(1, 2);

/* RMAP_INPUT, naming it, when the folder is not there in which the path would stand. */
enum rmap_status rmap_path_check_folder(const char *path, struct rmap_error *err) RMAP_MUST_USE;

/* "directory/.name.JOB.RESTART.HOST.PID.part"; rmap_free. NULL when memory is short. */
char *rmap_temporary_path(const char *directory, const char *name);

/* Gives a closed temporary file its final name in the same directory, durably, unless that name is
 * taken: *taken_ret says so, and nothing has happened then. RMAP_SYSTEM; the temporary file stays
 * as it is, for it may hold what cannot be had again. */
enum rmap_status rmap_publish_new(const char *directory, const char *temporary, const char *final,
                                  bool *taken_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The same in place of what has the name: a file, whose mode the new one takes over, or a link,
 * which is not followed. The temporary file is gone in any case. */
enum rmap_status rmap_publish_over(const char *directory, const char *temporary, const char *final,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Makes the names in a directory durable; in the directory that holds `path`. RMAP_SYSTEM. */
enum rmap_status rmap_sync_directory(const char *directory, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_sync_parent(const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
