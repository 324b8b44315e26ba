/* SPDX-License-Identifier: MIT
 *
 * Sources and detectors of a scene, marked and named.
 */
#ifndef RMAP_FIGURE_MARKS_H
#define RMAP_FIGURE_MARKS_H

#include "analysis/figure/figure_labels.h"

/* Sources that sent none of the rays are drawn faintly. mesh: [n_geometry], as in
 * rmap_section_draw. */
enum rmap_status rmap_marks_draw(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                 const struct rmap_portion *rays,
                                 const struct rmap_view_frame *frame, struct rmap_labels *labels,
                                 struct rmap_svg *svg, struct rmap_error *err) RMAP_MUST_USE;

/* The ink of sources and of detectors, for the legend. */
extern const char rmap_source_ink[], rmap_detector_ink[];

#endif
