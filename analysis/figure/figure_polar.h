/* SPDX-License-Identifier: MIT
 *
 * The intensity over the direction as a polar diagram, as luminaires' data sheets have it: a curve
 * for each of two planes through the axis, C0-C180 and C90-C270, theta = 0 downwards.
 */
#ifndef RMAP_FIGURE_POLAR_H
#define RMAP_FIGURE_POLAR_H

#include "analysis/detector/detector_image.h"
#include "io/export/svg.h"

/* image: over directions. criterion: NULL for all rays. The curves go through the middles of cells;
 * bands are of one standard error. */
enum rmap_status rmap_figure_polar(const struct rmap_detector_image *image, const char *criterion,
                                   struct rmap_svg **svg_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
