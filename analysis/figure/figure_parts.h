/* SPDX-License-Identifier: MIT
 *
 * Names of a scene's parts in its picture.
 */
#ifndef RMAP_FIGURE_PARTS_H
#define RMAP_FIGURE_PARTS_H

#include "analysis/figure/figure_labels.h"

/* In a section: the entries of the scene file, the largest in the picture, where their names find
 * room. */
enum rmap_status rmap_parts_name(const struct rmap_scene *scene,
                                 const struct rmap_view_frame *frame, struct rmap_labels *labels,
                                 struct rmap_svg *svg, struct rmap_error *err) RMAP_MUST_USE;

#endif
