/* SPDX-License-Identifier: MIT
 *
 * Importing a lens file.
 */
#ifndef RMAP_LENS_RUN_H
#define RMAP_LENS_RUN_H

#include "mpi/command/arguments.h"
#include "mpi/parallel/context.h"

/* By rank 0 alone. RMAP_USAGE: edits stand in the way, or another kind of import; RMAP_INPUT: it is
 * no lens, or `raymap check` refuses what was written; RMAP_STOPPED; RMAP_SYSTEM. */
enum rmap_status rmap_lens_import(const struct rmap_context *context,
                                  const struct rmap_arguments *given, const char *folder,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
