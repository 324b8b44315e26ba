/* SPDX-License-Identifier: MIT
 *
 * What path_matrix_print.c and path_matrix_out.c share.
 */
#ifndef RMAP_PATH_MATRIX_PART_H
#define RMAP_PATH_MATRIX_PART_H

#include "analysis/paths/path_matrix.h"

/* What a printer goes through: one detector's sums of one part. */
struct rmap_path_matrix_part {
    const struct rmap_path_matrix *matrix;
    const struct rmap_scene *scene;
    const struct rmap_path_cellsum *sum;
    size_t n;
    double flux, stray; /* that the detector registered */
};

/* The sums from *at on that are of one part and detector; moves *at behind them. */
struct rmap_path_matrix_part rmap_path_matrix_next(const struct rmap_path_matrix *matrix,
                                                   const struct rmap_path_cellsum *list, size_t n,
                                                   size_t *at);

/* Name of the object of a sum of LAST or MET; NULL: none. */
const char *rmap_path_matrix_object(const struct rmap_path_matrix *matrix,
                                    const struct rmap_path_cellsum *sum);

#endif
