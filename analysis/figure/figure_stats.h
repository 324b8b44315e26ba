/* SPDX-License-Identifier: MIT
 *
 * The picture of a histogram: of one number a step line per group with a band of one standard
 * error to either side; of two numbers the flux in false colours.
 */
#ifndef RMAP_FIGURE_STATS_H
#define RMAP_FIGURE_STATS_H

#include "analysis/stats/stats_text.h"
#include "io/export/svg.h"

enum rmap_status rmap_figure_stats(const struct rmap_stats *stats,
                                   const struct rmap_stats_labels *labels,
                                   struct rmap_svg **svg_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
