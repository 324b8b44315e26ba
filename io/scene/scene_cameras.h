/* SPDX-License-Identifier: MIT
 *
 * Cameras, and the light that comes from outside the scene: what pictures need beside the rest.
 */
#ifndef RMAP_SCENE_CAMERAS_H
#define RMAP_SCENE_CAMERAS_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_cameras(struct rmap_reader *reader);

/* The detectors of reader->receivers, with complaints in diagnostics of their own. */
void rmap_reader_read_background(struct rmap_reader *reader);

#endif
