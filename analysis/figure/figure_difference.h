/* SPDX-License-Identifier: MIT
 *
 * The picture of what differs where. Of an image: the difference, and beside it z, blue where the
 * first sample has less and red where it has more. Of a number: both samples with bands of one
 * standard error, and z below.
 */
#ifndef RMAP_FIGURE_DIFFERENCE_H
#define RMAP_FIGURE_DIFFERENCE_H

#include "analysis/compare/compare_bins.h"

/* The difference and z beside each other; of a number both samples over z. */
enum rmap_status rmap_figure_difference(const struct rmap_comparison *comparison,
                                        const struct rmap_compare_bins *bins,
                                        struct rmap_svg **svg_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
