/* SPDX-License-Identifier: MIT
 *
 * A scene as solid bodies seen from outside: shaded faces behind, visible edges as lines. What
 * encloses the scene on the eye's side (walls, a ceiling) is left out.
 */
#ifndef RMAP_FIGURE_SOLID_H
#define RMAP_FIGURE_SOLID_H

#include "analysis/figure_view.h"

/* mesh: [n_geometry], welded or tessellated, borrowed. */
enum rmap_status rmap_solid_draw(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                 const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* sRGB (0 to 1) of a face of such a surface in full light. */
const double *rmap_surface_tint(enum rmap_surface_type type);

#endif
