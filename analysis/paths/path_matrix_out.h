/* SPDX-License-Identifier: MIT
 *
 * How light came to detectors, as JSON and as CSV; and the criteria of its parts.
 */
#ifndef RMAP_PATH_MATRIX_OUT_H
#define RMAP_PATH_MATRIX_OUT_H

#include "analysis/paths/path_matrix.h"

/* For people: at most `top` rows of a ranking. */
enum rmap_status rmap_path_matrix_print(const struct rmap_path_matrix *matrix,
                                        const struct rmap_path_cellsum *list, size_t n,
                                        uint64_t top, FILE *out,
                                        struct rmap_error *err) RMAP_MUST_USE;
/* Sets "orders", "ghosts" and "contribution" as asked for. */
enum rmap_status rmap_path_matrix_json(const struct rmap_path_matrix *matrix,
                                       const struct rmap_path_cellsum *list, size_t n,
                                       json_t *document, struct rmap_error *err) RMAP_MUST_USE;
/* The one matrix that matrix->parts asks for. */
enum rmap_status rmap_path_matrix_csv(const struct rmap_path_matrix *matrix,
                                      const struct rmap_path_cellsum *list, size_t n, FILE *out,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
