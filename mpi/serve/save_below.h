/* SPDX-License-Identifier: MIT
 *
 * Files that who talks to a server may write: below one folder, by no way around.
 */
#ifndef RMAP_SAVE_BELOW_H
#define RMAP_SAVE_BELOW_H

#include <stdbool.h>

#include "base/status.h"

/* A text into a file at a path below the folder, whole or not at all. The path is relative to the
 * folder, or begins with it; ".." and links are refused, in any part of it. force: a file that
 * stands there is replaced. RMAP_USAGE, RMAP_INPUT: a folder is not there, RMAP_SYSTEM. */
enum rmap_status rmap_save_below(const char *folder, const char *path, const char *text, bool force,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
