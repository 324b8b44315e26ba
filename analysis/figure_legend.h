/* SPDX-License-Identifier: MIT
 *
 * What the lines of a drawing mean, and how long they are.
 */
#ifndef RMAP_FIGURE_LEGEND_H
#define RMAP_FIGURE_LEGEND_H

#include "analysis/figure_view.h"
#include "analysis/ray_paint.h"
#include "trace/portion.h"

/* Samples of every ink in use, in rows below the frame, left of the scale bar. paint: NULL as in
 * struct rmap_ray_lines. mixed: the rays are in several colour spaces, and no wavelength is listed.
 * Returns how far below the frame the last row stands, which with svg NULL is all that it does. */
#define RMAP_LEGEND_ROW 20.0
double rmap_legend_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                        const struct rmap_view_frame *frame, const struct rmap_ray_paint *paint,
                        bool mixed, struct rmap_svg *svg);

/* A bar of round length below the frame's right end, with its length. */
void rmap_scale_bar_draw(const struct rmap_scene *scene, const struct rmap_view_frame *frame,
                         struct rmap_svg *svg);

/* Arrows along the world's axes in the frame's lower left corner. */
void rmap_axis_cross_draw(const struct rmap_view_frame *frame, struct rmap_svg *svg);

#endif
