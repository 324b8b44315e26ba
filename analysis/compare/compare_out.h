/* SPDX-License-Identifier: MIT
 *
 * A comparison as a table for people and as JSON.
 */
#ifndef RMAP_COMPARE_OUT_H
#define RMAP_COMPARE_OUT_H

#include "analysis/compare/compare.h"

/* both: sums of the rays that both samples hold, or NULL; products [2]: of the first two samples
 * above, for the images in `again`. */
struct rmap_compare_products;
enum rmap_status rmap_comparison_add_products(struct rmap_comparison *comparison,
                                              const struct rmap_compare_sums *both,
                                              const struct rmap_compare_products *const products[2],
                                              struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_comparison_print(const struct rmap_comparison *comparison, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_comparison_json(const struct rmap_comparison *comparison); /* NULL: no memory */

#endif
