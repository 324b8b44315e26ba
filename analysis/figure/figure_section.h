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

/* How surfaces are drawn: in a legend, as an outline, as a face in full light (sRGB, 0 to 1). */
struct rmap_look_style {
    const char *word, *ink;
    double tint[3];
};
extern const struct rmap_look_style rmap_look_style[RMAP_LOOK_COUNT];

#endif
