/* SPDX-License-Identifier: MIT
 *
 * Values of stored columns that index tables of the scene: whatever a file says, they must lie in
 * them.
 */
#ifndef RMAP_SCENE_LIMITS_H
#define RMAP_SCENE_LIMITS_H

#include "portion/portion.h"
#include "scene/scene.h"

/* Whether all values of a column, which is there, name something of the scene; true of columns that
 * name nothing. */
bool rmap_portion_within(const struct rmap_scene *scene, const struct rmap_portion *portion,
                         enum rmap_column column);

#endif
