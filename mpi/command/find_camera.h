/* SPDX-License-Identifier: MIT
 *
 * The camera that a command line names.
 */
#ifndef RMAP_FIND_CAMERA_H
#define RMAP_FIND_CAMERA_H

#include "scene/scene.h"

/* name NULL: the first. path: of the scene or the map, for messages. RMAP_INPUT, with the nearest
 * name, when there is none of that name. */
enum rmap_status rmap_find_camera(const struct rmap_scene *scene, const char *path,
                                  const char *name, const struct rmap_camera **camera_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
