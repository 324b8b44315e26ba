/* SPDX-License-Identifier: MIT
 *
 * Walking through a directory whose files have numbered names.
 */
#ifndef RMAP_DIRECTORY_H
#define RMAP_DIRECTORY_H

#include "base/status.h"

/* Numbers of shards and pieces have five digits. */
#define RMAP_NUMBER_END 100000

/* The number in "prefixNNNNNsuffix", or -1. */
int rmap_directory_number(const char *name, const char *prefix, const char *suffix);

/* Calls visit for every entry but . and .. until it fails. RMAP_SYSTEM, or what visit says. */
enum rmap_status rmap_directory_visit(const char *path,
                                      enum rmap_status (*visit)(void *context, const char *name,
                                                                struct rmap_error *err),
                                      void *context, struct rmap_error *err) RMAP_MUST_USE;

#endif
