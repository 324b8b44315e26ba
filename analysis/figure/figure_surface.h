/* SPDX-License-Identifier: MIT
 *
 * The picture of a surface: which shares of the light it reflects, lets through and absorbs, over
 * the angle and, where the scene has light of several, over wavelength.
 */
#ifndef RMAP_FIGURE_SURFACE_H
#define RMAP_FIGURE_SURFACE_H

#include "io/export/svg.h"
#include "trace/surface_shares.h"

enum { RMAP_SURFACE_SIDES_MAX = 2, RMAP_FIGURE_INCIDENCES = 3 };
/* Angles of incidence, in degrees, at which a BSDF is shown. */
static const double rmap_figure_incidence[RMAP_FIGURE_INCIDENCES] = {0.0, 30.0, 60.0};

/* side: [n] 1 or 2, of one surface. channel: of the curves over the angle. */
enum rmap_status rmap_figure_surface(const struct rmap_scene *scene,
                                     const struct rmap_surface_side *side, size_t n, int channel,
                                     const char *title, struct rmap_svg **svg_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
