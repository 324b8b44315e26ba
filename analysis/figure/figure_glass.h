/* SPDX-License-Identifier: MIT
 *
 * The picture of materials: the index over wavelength and, below it, what 10 mm let through, or k
 * where that is nothing.
 */
#ifndef RMAP_FIGURE_GLASS_H
#define RMAP_FIGURE_GLASS_H

#include "io/export/svg.h"
#include "optics/glass.h"

#define RMAP_FIGURE_GLASSES_MAX 16

/* n: 1 to RMAP_FIGURE_GLASSES_MAX. */
enum rmap_status rmap_figure_glass(const struct rmap_glass *glass, size_t n,
                                   struct rmap_svg **svg_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
