/* SPDX-License-Identifier: MIT
 *
 * A file for a result that appears whole or not at all: written under a temporary name beside its
 * own that nobody can foretell, and what had the name keeps it until then.
 */
#ifndef RMAP_WHOLE_FILE_H
#define RMAP_WHOLE_FILE_H

#include <stdio.h>

#include "base/status.h"

struct rmap_whole_file {
    const char *path;            /* borrowed */
    char *directory, *temporary; /* the latter until it has its name */
    FILE *file;                  /* to write to; its errors are found at the end */
};

/* For who makes a file by its name, whole->temporary, where none may be, and closes it; `file`
 * stays NULL. RMAP_SYSTEM. */
enum rmap_status rmap_whole_file_name(struct rmap_whole_file *whole, const char *path,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_SYSTEM when it cannot be written there. */
enum rmap_status rmap_whole_file_open(struct rmap_whole_file *whole, const char *path,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Gives it its name, in place of what had it. RMAP_SYSTEM, and the temporary file is gone. */
enum rmap_status rmap_whole_file_finish(struct rmap_whole_file *whole,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* All of it in one go, from what `put` writes; its status, and the file's. */
enum rmap_status rmap_whole_file_put(const char *path,
                                     enum rmap_status (*put)(const void *context, FILE *file,
                                                             struct rmap_error *err),
                                     const void *context, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_whole_file_put_bytes(const char *path, const void *bytes, size_t nbytes,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Releases; a file that was not finished is removed. Zeroed: fine. */
void rmap_whole_file_fini(struct rmap_whole_file *whole);

#endif
