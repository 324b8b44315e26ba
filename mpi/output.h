/* SPDX-License-Identifier: MIT
 *
 * Where a command may write its result.
 */
#ifndef RMAP_OUTPUT_H
#define RMAP_OUTPUT_H

#include <stdbool.h>

#include "base/status.h"

/* RMAP_USAGE unless the name ends in one of the suffixes (".png", ..., NULL; any case) and
 * nothing stands there, or `force` is given. */
enum rmap_status rmap_output_check(const char *path, const char *const *suffix, bool force,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
