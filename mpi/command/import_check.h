/* SPDX-License-Identifier: MIT
 *
 * Whether `raymap check` takes what an import writes.
 */
#ifndef RMAP_IMPORT_CHECK_H
#define RMAP_IMPORT_CHECK_H

#include <jansson.h>

#include "io/file/diagnostics.h"
#include "mpi/parallel/context.h"

struct rmap_import_text {
    const char *path;
    const char *text;       /* that stands there, or will; NULL: that of the file */
    const char *simulation; /* NULL: none is chosen */
};

/* Adds what `raymap check` says, once. RMAP_SYSTEM. */
enum rmap_status rmap_import_check(const struct rmap_context *context,
                                   const struct rmap_import_text *text,
                                   struct rmap_diagnostics *told,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_INPUT where it refuses the scene. */
enum rmap_status rmap_import_refused(const char *scene, const struct rmap_diagnostics *told,
                                     struct rmap_error *err) RMAP_MUST_USE;

json_t *rmap_json_check(const struct rmap_diagnostics *told);

#endif
