/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion as lines in the colour of their light, darkened to show on white paper.
 */
#ifndef RMAP_FIGURE_RAYS_H
#define RMAP_FIGURE_RAYS_H

#include "analysis/figure_view.h"
#include "io/map_reader.h"
#include "trace/portion.h"

/* rays has all columns; curved legs follow their points. A leg that leaves the scene is drawn
 * `leaving` length units long. map: as in struct rmap_figure_draw. */
enum rmap_status rmap_rays_draw(const struct rmap_scene *scene, const struct rmap_map *map,
                                const struct rmap_portion *rays,
                                const struct rmap_view_frame *frame, double leaving,
                                struct rmap_svg *svg, struct rmap_error *err) RMAP_MUST_USE;

/* "#rrggbb" on white paper for light with these shares. */
void rmap_ray_ink(const struct rmap_scene *scene, const double *share, char ink[8]);

#endif
