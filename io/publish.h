/* SPDX-License-Identifier: MIT
 *
 * Files appear under their final names whole or not at all: written under a temporary name that
 * carries job, restart count, host and process, synced, then linked without overwriting.
 */
#ifndef RMAP_PUBLISH_H
#define RMAP_PUBLISH_H

#include "base/status.h"

/* "directory/name" made from a format; rmap_free. NULL when memory is short. */
char *rmap_path_format(const char *format, ...) RMAP_PRINTF(1, 2);

/* "directory/.name.JOB.RESTART.HOST.PID.part"; rmap_free. NULL when memory is short. */
char *rmap_temporary_path(const char *directory, const char *name);

/* Gives a closed temporary file its final name in the same directory, durably. RMAP_SYSTEM when
 * that fails; publish_new also when the final name is taken. The temporary name is gone then. */
enum rmap_status rmap_publish_new(const char *directory, const char *temporary, const char *final,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_publish_over(const char *directory, const char *temporary, const char *final,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
