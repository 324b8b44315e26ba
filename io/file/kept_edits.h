/* SPDX-License-Identifier: MIT
 *
 * Texts that the program writes for people to edit, and may write again: the last line has a digest
 * of all before it, so that edits are found and never lost without a word.
 */
#ifndef RMAP_KEPT_EDITS_H
#define RMAP_KEPT_EDITS_H

#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

enum rmap_edits {
    RMAP_EDITS_NO_FILE,
    RMAP_EDITS_NONE, /* it is as it was written */
    RMAP_EDITS_MADE  /* or it was never written by rmap_edits_put */
};

/* RMAP_SYSTEM: it stands there and cannot be read. */
enum rmap_status rmap_edits_find(const char *path, enum rmap_edits *edits,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Writes what `put` writes and the line with its digest. A file with edits is RMAP_USAGE with the
 * remedy, unless `force`: then it is kept as "PATH.bak" (.bak.2 and so on where that is taken),
 * which *kept_ret names; rmap_free; NULL: none was. */
enum rmap_status
rmap_edits_put(const char *path, bool force,
               enum rmap_status (*put)(const void *context, FILE *file, struct rmap_error *err),
               const void *context, char **kept_ret, struct rmap_error *err) RMAP_MUST_USE;

/* What is said where edits stand in the way: RMAP_USAGE. */
enum rmap_status rmap_edits_refuse(const char *path, struct rmap_error *err);

#endif
