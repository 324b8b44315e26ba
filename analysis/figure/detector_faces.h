/* SPDX-License-Identifier: MIT
 *
 * Detectors on curved surfaces and on faces of meshes, drawn where they count light.
 */
#ifndef RMAP_DETECTOR_FACES_H
#define RMAP_DETECTOR_FACES_H

#include "analysis/figure/figure_view.h"

/* The faces on which it counts light, as far as the detector's size goes: where a section cuts
 * them, else their rims and creases. mesh: [n_geometry], as in rmap_section_draw. *flat_ret: the
 * detector lies on nothing, on faces in its own plane, or on a body without rims: nothing is drawn
 * then, for its rectangle tells as much. Else *at is a point of what was drawn; NaN: nothing was.
 */
enum rmap_status rmap_detector_faces_draw(const struct rmap_scene *scene,
                                          struct rmap_mesh *const *mesh,
                                          const struct rmap_view_frame *frame, size_t detector,
                                          const struct rmap_svg_style *style, struct rmap_svg *svg,
                                          bool *flat_ret, struct rmap_vec3 *at,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
