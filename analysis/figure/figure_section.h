/* SPDX-License-Identifier: MIT
 *
 * A scene cut by a plane: profiles of all surfaces, glass between them filled.
 */
#ifndef RMAP_FIGURE_SECTION_H
#define RMAP_FIGURE_SECTION_H

#include "analysis/figure/figure_view.h"

/* mesh: [n_geometry], welded or tessellated, borrowed. */
enum rmap_status rmap_section_draw(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                   const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Ink for an object's outline, by what its surface does; each ink is one string. */
const char *rmap_surface_ink(enum rmap_surface_type type);
const char *rmap_object_ink(const struct rmap_scene *scene, size_t object);

#endif
