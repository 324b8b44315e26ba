/* SPDX-License-Identifier: MIT
 *
 * What is likely wrong with bodies, found without light: meshes that are not closed around their
 * medium, meshes in other units than the scene.
 */
#ifndef RMAP_BODY_CHECK_H
#define RMAP_BODY_CHECK_H

#include "io/file/diagnostics.h"
#include "scene/scene.h"

/* Adds warnings where the objects stand in the file. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_bodies_check(const struct rmap_scene *scene,
                                   struct rmap_diagnostics *diagnostics,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
