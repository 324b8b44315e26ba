/* SPDX-License-Identifier: MIT
 *
 * Files of `raymap compare`.
 */
#ifndef RMAP_COMPARE_WRITE_H
#define RMAP_COMPARE_WRITE_H

#include "analysis/compare/compare_bins.h"

/* Ends with NULL. */
extern const char *const rmap_compare_suffixes[];

/* By the suffix. JSON: the whole comparison with all bins; the others: bins[0]; without any,
 * RMAP_INPUT. */
enum rmap_status rmap_compare_write(const struct rmap_comparison *comparison,
                                    const struct rmap_compare_bins *const *bins, size_t n_bins,
                                    const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
