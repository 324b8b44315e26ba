/* SPDX-License-Identifier: MIT
 *
 * Importing a model, and updating what was imported by a new revision of it.
 */
#ifndef RMAP_MODEL_RUN_H
#define RMAP_MODEL_RUN_H

#include "mpi/command/arguments.h"
#include "mpi/parallel/context.h"

#define RMAP_MODEL_OPTIONS                                                                         \
    {"chord", 0, "MM",                                                                             \
     "STEP, IGES: how far triangles may lie from the surface (default 0.001 of "                   \
     "each shape's size)"},                                                                        \
        {"angle", 0, "DEG", "STEP, IGES: most between neighbouring chords (default 10)"},          \
    {                                                                                              \
        "unit", 0, "UNIT", "of OBJ, STL and PLY, which have none: nm um mm cm m in (default mm)"   \
    }

/* RMAP_USAGE: an option that says nothing of such a file. */
enum rmap_status rmap_model_check_options(const struct rmap_arguments *given, const char *path,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* By rank 0 alone. RMAP_USAGE: edits stand in the way; RMAP_INPUT: it is no model; RMAP_SYSTEM. */
enum rmap_status rmap_model_import(const struct rmap_context *context,
                                   const struct rmap_arguments *given, const char *folder,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_model_update(const struct rmap_context *context,
                                   const struct rmap_arguments *given,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
