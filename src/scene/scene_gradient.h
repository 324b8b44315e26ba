/* SPDX-License-Identifier: MIT
 *
 * Gradient media in place: a place for every frame in which a gradient medium stands.
 */
#ifndef RMAP_SCENE_GRADIENT_H
#define RMAP_SCENE_GRADIENT_H

#include "scene/scene.h"

/* Sides of objects (sources, cameras) may already name a place of scene->gradient, of which medium
 * and to_world count. Every other side whose medium has a field gets one in its object's own frame.
 * Equal places become one, unused ones go; then inverses, sizes and options are filled in. A
 * source or camera in a gradient medium gets the medium's place when there is one alone. For
 * rmap_scene_finish, after the scene's bounds are known. RMAP_INPUT: a source that could stand in
 * several places, a singular frame. */
enum rmap_status rmap_scene_place_gradients(struct rmap_scene *scene,
                                            struct rmap_error *err) RMAP_MUST_USE;

#endif
