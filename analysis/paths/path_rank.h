/* SPDX-License-Identifier: MIT
 *
 * The first of many classes of paths, in the order of a table.
 */
#ifndef RMAP_PATH_RANK_H
#define RMAP_PATH_RANK_H

#include "analysis/paths/path_report.h"

/* A class while classes are ranked. */
struct rmap_path_ranked {
    size_t class;
    struct rmap_key key; /* of the class: a ray may be the first of several */
    uint64_t first_ray;
    double value; /* the greater, the earlier */
    double flux;
};

/* *ranked_ret: [n_row] the first of the classes, of which there are n_row or more; rmap_free.
 * RMAP_SYSTEM. */
enum rmap_status rmap_path_rank(const struct rmap_path_counts *counts, enum rmap_path_sort sort,
                                size_t n_row, struct rmap_path_ranked **ranked_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
