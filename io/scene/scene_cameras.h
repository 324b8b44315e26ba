/* SPDX-License-Identifier: MIT
 *
 * Cameras, and the light that comes from outside the scene: what pictures need beside the rest.
 */
#ifndef RMAP_SCENE_CAMERAS_H
#define RMAP_SCENE_CAMERAS_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_cameras(struct rmap_reader *reader);

/* Where a camera stands and looks, and what it sees: keys from `at` to `focal_length` and, of a
 * thin lens, `focus`, which may be left out (0) where a point is looked at, or `far`. */
void rmap_reader_view(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool far,
                      struct rmap_camera *camera);

/* The detectors of reader->receivers, with complaints in diagnostics of their own. */
void rmap_reader_read_background(struct rmap_reader *reader);

#endif
