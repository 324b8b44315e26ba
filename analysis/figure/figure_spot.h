/* SPDX-License-Identifier: MIT
 *
 * The curves of a spot: encircled energy over the radius, and the MTF beside it, with bands of one
 * standard error.
 */
#ifndef RMAP_FIGURE_SPOT_H
#define RMAP_FIGURE_SPOT_H

#include "analysis/detector/spot.h"
#include "io/export/svg.h"

/* criterion: NULL for all rays. */
enum rmap_status rmap_figure_spot(const struct rmap_spot *spot, const char *detector,
                                  const char *criterion, struct rmap_svg **svg_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
