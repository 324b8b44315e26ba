/* SPDX-License-Identifier: MIT
 *
 * Every geometry of a scene as a mesh to look at.
 */
#ifndef RMAP_SCENE_MESH_H
#define RMAP_SCENE_MESH_H

#include "scene/scene.h"

/* [n_geometry], welded or tessellated (tessellation.h). */
enum rmap_status rmap_scene_meshes_create(const struct rmap_scene *scene,
                                          struct rmap_mesh ***mesh_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_scene_meshes_destroy(struct rmap_mesh **mesh, size_t n_geometry); /* NULL is fine */

#endif
