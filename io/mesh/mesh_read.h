/* SPDX-License-Identifier: MIT
 *
 * Meshes from files: STL and OBJ through assimp, which is asked to triangulate and for nothing
 * else, and is given one file's bytes; PLY and glTF by mesh_ply.c and mesh_gltf.c.
 */
#ifndef RMAP_MESH_READ_H
#define RMAP_MESH_READ_H

#include "io/mesh/bundle.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/obj_names.h"

/* Kept of texture coordinates: where u grows on each triangle, and they themselves; and of faces
 * that lie on surfaces the triangles alone. */
enum { RMAP_MESH_TANGENTS = 1, RMAP_MESH_UV = 2, RMAP_MESH_FLAT = 4 };

struct rmap_mesh_reading {
    double scale;      /* of the file's lengths */
    unsigned keep;     /* bits of the above */
    const char *cache; /* a folder of meshes that were read before (mesh_cache.h); NULL: none */
    struct rmap_error *note; /* why the cache was of no use, which is no failure; or NULL */
};

/* RMAP_INPUT with the path when it is no mesh. */
enum rmap_status rmap_mesh_read(const char *path, const struct rmap_mesh_reading *how,
                                struct rmap_mesh **mesh_ret,
                                struct rmap_mesh_left_out *left_out_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* What is in a file, with its parts and materials as an OBJ file names them. */
struct rmap_mesh_file {
    struct rmap_mesh *mesh;
    char **material;             /* [n_face] NULL or "": none */
    int32_t *part;               /* [n_face] -1: of none that has a name */
    struct rmap_obj_names names; /* of parts */
    struct rmap_mesh_left_out left_out;
};

/* Zero-initialise, fini in any case. */
enum rmap_status rmap_mesh_read_file(const char *path, double scale, struct rmap_mesh_file *file,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_mesh_file_fini(struct rmap_mesh_file *file);

#endif
