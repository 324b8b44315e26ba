/* SPDX-License-Identifier: MIT
 *
 * What detectors have registered up to a time, as dots where the light was.
 */
#ifndef RMAP_FIGURE_REGISTERED_H
#define RMAP_FIGURE_REGISTERED_H

#include "analysis/figure/figure_rays.h"

/* Draws those up to the end of lines->window on planes; how many there are up to then, on any
 * detector. rays: all columns, of the scene's detectors. */
uint64_t rmap_registered_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                              const struct rmap_ray_lines *lines, struct rmap_svg *svg);

#endif
