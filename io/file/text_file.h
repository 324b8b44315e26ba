/* SPDX-License-Identifier: MIT
 *
 * A file of text that a person wrote, read as a whole.
 */
#ifndef RMAP_TEXT_FILE_H
#define RMAP_TEXT_FILE_H

#include <stddef.h>

#include "base/status.h"

/* What is wanted, for the messages. */
struct rmap_text_kind {
    const char *noun;   /* "a scene file" */
    const char *format; /* "YAML text"; NULL, of files that scenes name: any bytes */
    const char *advice; /* " (meshes belong into files of their own)", or "" */
    size_t nbytes_max;
};

/* A regular file, or a pipe that has a writer, of at most kind->nbytes_max bytes. *text_ret: with a
 * final 0, rmap_free. RMAP_INPUT: missing, a directory, empty, too long or binary; RMAP_SYSTEM: no
 * permission, no memory. */
enum rmap_status rmap_text_file_read(const char *path, const struct rmap_text_kind *kind,
                                     char **text_ret, size_t *nbytes_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
