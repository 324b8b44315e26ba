/* SPDX-License-Identifier: MIT
 *
 * Distributions for a comparison: of classes of paths, and of any number.
 */
#ifndef RMAP_COMPARE_FIELDS_H
#define RMAP_COMPARE_FIELDS_H

#include "analysis/compare/compare_bins.h"
#include "mpi/answer/compare_samples.h"

/* Collective. Adds a test of the paths, on rank 0. */
enum rmap_status rmap_compare_paths_run(const struct rmap_context *context,
                                        const struct rmap_compare_samples *samples,
                                        struct rmap_comparison *comparison,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The same of a number. *bins_ret (NULL: not wanted): on rank 0 the distributions, NULL
 * where nothing has a value. */
struct rmap_compare_number {
    const char *of;       /* "path_length" */
    const char *detector; /* or NULL; as --detector of raymap stats */
    size_t n_bin; /* equally wide; 0: about 50 with as many rays each, or one per whole number */
    const char *range; /* "1..2 mm"; NULL: all that there is */
};
enum rmap_status rmap_compare_number_run(const struct rmap_context *context,
                                         const struct rmap_compare_samples *samples,
                                         const struct rmap_compare_number *number,
                                         struct rmap_comparison *comparison,
                                         struct rmap_compare_bins **bins_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
