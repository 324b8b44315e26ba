/* SPDX-License-Identifier: MIT
 *
 * Where and how a command may write its result.
 */
#ifndef RMAP_OUTPUT_H
#define RMAP_OUTPUT_H

#include <stdbool.h>

#include "base/status.h"
#include "compact/layout.h"

/* RMAP_USAGE unless the name ends in one of the suffixes (".png", ..., NULL; any case) and
 * nothing stands there, or `force` is given. */
enum rmap_status rmap_output_check(const char *path, const char *const *suffix, bool force,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE where something stands at the path: of a file, unless `force` is given. */
enum rmap_status rmap_output_free(const char *path, bool force,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Whether a name ends in a suffix such as ".csv", in any case, and is more than that. */
bool rmap_output_is(const char *path, const char *suffix);

/* "plain" or "compact"; word NULL: RMAP_ENCODING_COUNT. RMAP_USAGE. */
enum rmap_status rmap_output_encoding(const char *word, enum rmap_encoding *encoding,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Whether two paths name one directory, however they are written. */
bool rmap_same_place(const char *a, const char *b);

#endif
