/* SPDX-License-Identifier: MIT
 *
 * Files that a scene names: a stranger's scene may name anything.
 */
#ifndef RMAP_INPUT_FILE_H
#define RMAP_INPUT_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* NULL where the path is a regular file that can be opened; else why it is not read. Never waits,
 * as opening a pipe without a writer would. The text is valid until the next call of the thread. */
const char *rmap_input_file_trouble(const char *path);

/* All of such a file, with a 0 behind it; rmap_free. RMAP_INPUT: it is none, or longer than
 * nbytes_max; RMAP_SYSTEM: it cannot be read, no memory. The text does not name the path. */
enum rmap_status rmap_input_file_read(const char *path, size_t nbytes_max, uint8_t **bytes_ret,
                                      size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Whether the environment allows the plug-in at `path`: RAYMAP_ALLOW_PLUGINS names its file, or a
 * folder that holds it, perhaps further down, as one of several paths with ':' between them. Links
 * are resolved on both sides. */
bool rmap_plugin_is_allowed(const char *path);

#endif
