/* SPDX-License-Identifier: MIT
 *
 * What the lines of a drawing mean, and how long they are.
 */
#ifndef RMAP_FIGURE_LEGEND_H
#define RMAP_FIGURE_LEGEND_H

#include "analysis/figure/figure_view.h"
#include "analysis/figure/ray_paint.h"
#include "portion/portion.h"

/* Samples of every ink in use, in rows below the frame: groups of rays as wide as that, then the
 * others left of the scale bar. paint: NULL as in struct rmap_ray_lines. colour: objects'. mixed:
 * the rays are in several colour spaces, and no wavelength is listed. *marks_ret: how far below the
 * frame the first row of the others stands, where the scale bar belongs. Returns how far the last
 * row does. With svg NULL these two are all that it tells. */
#define RMAP_LEGEND_ROW 20.0
double rmap_legend_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                        const struct rmap_view_frame *frame, const struct rmap_ray_paint *paint,
                        const double (*colour)[3], bool mixed, double *marks_ret,
                        struct rmap_svg *svg);

/* A bar of round length, with its length, at the frame's right end and `row` below it; of a
 * stretched section one for each direction. */
void rmap_scale_bar_draw(const struct rmap_scene *scene, const struct rmap_view_frame *frame,
                         double row, struct rmap_svg *svg);

/* Arrows along the world's axes in the frame's lower left corner. */
void rmap_axis_cross_draw(const struct rmap_view_frame *frame, struct rmap_svg *svg);

#endif
