/* SPDX-License-Identifier: MIT
 *
 * Meshes from files: STL and OBJ through assimp, which is asked to triangulate and for nothing
 * else, and is given one file's bytes; PLY and glTF by mesh_ply.c and mesh_gltf.c.
 */
#ifndef RMAP_MESH_READ_H
#define RMAP_MESH_READ_H

#include "io/mesh/bundle.h"
#include "io/mesh/mesh_builder.h"

/* scale: of the file's lengths; tangents: keeps where u grows, of a texture. RMAP_INPUT with the
 * path when it is no mesh. */
enum rmap_status rmap_mesh_read(const char *path, double scale, bool tangents,
                                struct rmap_mesh **mesh_ret,
                                struct rmap_mesh_left_out *left_out_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The same with the materials that an OBJ file names; *material_ret: [n_face], with NULL or ""
 * where there is none, each and all to be freed. */
enum rmap_status rmap_mesh_read_parts(const char *path, double scale, struct rmap_mesh **mesh_ret,
                                      char ***material_ret, struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_mesh_copy(const struct rmap_mesh *from, struct rmap_mesh **mesh_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
