/* SPDX-License-Identifier: MIT
 *
 * Meshes from files: STL and OBJ through assimp, which is asked to triangulate and for nothing
 * else, and is given one file's bytes; PLY and glTF by mesh_ply.c and mesh_gltf.c.
 */
#ifndef RMAP_MESH_READ_H
#define RMAP_MESH_READ_H

#include "io/mesh/bundle.h"
#include "io/mesh/mesh_builder.h"

/* Kept of texture coordinates: where u grows on each triangle, and they themselves. */
enum { RMAP_MESH_TANGENTS = 1, RMAP_MESH_UV = 2 };

/* scale: of the file's lengths; keep: bits of the above. RMAP_INPUT with the path when it is no
 * mesh. */
enum rmap_status rmap_mesh_read(const char *path, double scale, unsigned keep,
                                struct rmap_mesh **mesh_ret,
                                struct rmap_mesh_left_out *left_out_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The same with the materials that an OBJ file names; *material_ret: [n_face], with NULL or ""
 * where there is none, each and all to be freed. */
enum rmap_status rmap_mesh_read_parts(const char *path, double scale, struct rmap_mesh **mesh_ret,
                                      char ***material_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
