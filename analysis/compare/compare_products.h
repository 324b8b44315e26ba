/* SPDX-License-Identifier: MIT
 *
 * How merged cells of images vary together, ray by ray: where rays are registered on a detector
 * more than once, its cells are not independent.
 */
#ifndef RMAP_COMPARE_PRODUCTS_H
#define RMAP_COMPARE_PRODUCTS_H

#include "analysis/compare/compare.h"

/* Plain data; rmap_compare_products_layout_fini. */
struct rmap_compare_products_layout {
    const struct rmap_compare_layout *of; /* borrowed */
    const int32_t **group;                /* [n_detector][cells] borrowed; NULL: not looked at */
    size_t *n_group;                      /* [n_detector] */
    size_t *first;                        /* [n_detector + 1] of the detector's values */
    size_t n_value;                       /* per source */
};

/* For the images that a comparison looks at again, in its first or second map (which: 0 or 1).
 * RMAP_SYSTEM, with the reason, where there would be too many numbers. */
enum rmap_status rmap_compare_products_layout_init(struct rmap_compare_products_layout *layout,
                                                   const struct rmap_compare_layout *of,
                                                   const struct rmap_comparison *comparison,
                                                   int which, struct rmap_error *err) RMAP_MUST_USE;
void rmap_compare_products_layout_fini(struct rmap_compare_products_layout *layout);

struct rmap_compare_products {
    const struct rmap_compare_products_layout *layout; /* borrowed */
    /* [n_source][n_value]: of each detector [n_group] sums, then the lower triangle of sums of
     * products. */
    double *value;
    double *own; /* [most groups] of the ray in hand */
    size_t *met; /* [most groups] which of them are not 0 */
};

/* context: struct rmap_compare_products_layout; state: struct rmap_compare_products. Columns:
 * RMAP_COMPARE_SUMS_COLUMNS. */
extern const struct rmap_fold_kind rmap_compare_products_kind;

#endif
