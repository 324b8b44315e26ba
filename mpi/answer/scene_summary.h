/* SPDX-License-Identifier: MIT
 *
 * What is in a scene, for `raymap check`.
 */
#ifndef RMAP_SCENE_SUMMARY_H
#define RMAP_SCENE_SUMMARY_H

#include <jansson.h>
#include <stdio.h>

#include "scene/scene.h"

void rmap_scene_summary_print(const struct rmap_scene *scene, FILE *out);

/* A new object; NULL when memory is short. */
json_t *rmap_scene_summary_json(const struct rmap_scene *scene);

#endif
