/* SPDX-License-Identifier: MIT
 *
 * The detector that a command line names.
 */
#ifndef RMAP_FIND_DETECTOR_H
#define RMAP_FIND_DETECTOR_H

#include "scene/scene.h"

/* RMAP_INPUT, with the nearest name, when the scene has none of that name. */
enum rmap_status rmap_find_detector(const struct rmap_scene *scene, const char *name,
                                    int32_t *detector_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
