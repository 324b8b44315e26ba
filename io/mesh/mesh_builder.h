/* SPDX-License-Identifier: MIT
 *
 * A mesh made triangle by triangle. Equal positions become one vertex, so that neighbouring
 * triangles share their edges to the bit; triangles without an area are dropped and counted.
 */
#ifndef RMAP_MESH_BUILDER_H
#define RMAP_MESH_BUILDER_H

#include <stdbool.h>

#include "geometry/mesh.h"

/* Triangles of a file that a mesh does without, and whether the file is all that it was made of. */
struct rmap_mesh_left_out {
    size_t degenerate; /* without an area */
    size_t undefined;  /* with a corner that is no number, or infinite */
    size_t first;      /* number of the first of these in the file, from 1 */
    size_t untrue;  /* faces whose triangles do not lie on the surface that the file gives them */
    bool elsewhere; /* is read of more files than one */
};

struct rmap_mesh_builder {
    float (*vertex)[3];
    uint32_t (*triangle)[3];
    uint32_t *face;
    char **face_name, **face_material; /* the latter and parts where they are wanted */
    int32_t *face_part;                /* of the file; -1: it names none */
    struct rmap_true_surface *surface; /* [n_face]; NULL: no file gave one */
    float (*tangent)[3]; /* of those that had texture coordinates; only where they are wanted */
    float (*uv)[6];      /* as of a struct rmap_mesh; only where they are wanted */
    bool wants_tangents, wants_uv, has_tangents, has_uv, wants_materials;
    bool v_down;  /* of the file's texture coordinates */
    int32_t part; /* that faces are of which are closed next */
    size_t n_vertex, n_triangle, n_face, n_face_material;
    size_t cap_vertex, cap_triangle, cap_face, cap_face_name, cap_face_material, cap_face_part,
        cap_tangent, cap_uv, cap_surface;
    uint32_t *slot; /* vertices by position; 0: free, else index + 1 */
    size_t n_slot;
    struct rmap_mesh_left_out left_out;
    struct rmap_error *err;
};

/* Zero-initialise, set err (and wants_tangents, wants_uv), then: any number of triangles and faces.
 * A triangle belongs to the face that will be closed next. uv: [3][2], texture coordinates; NULL:
 * none. RMAP_INPUT when there are too many. */
enum rmap_status rmap_mesh_builder_add(struct rmap_mesh_builder *builder,
                                       const struct rmap_vec3 corner[3],
                                       const double *uv) RMAP_MUST_USE;

/* Ends the face of the triangles added since the last one ended; without any, there is none.
 * The name is copied; NULL: none. */
enum rmap_status rmap_mesh_builder_close_face(struct rmap_mesh_builder *builder,
                                              const char *name) RMAP_MUST_USE;

/* The same of a face that lies on a surface; all faces are closed so, or none. */
enum rmap_status
rmap_mesh_builder_close_surface(struct rmap_mesh_builder *builder, const char *name,
                                const struct rmap_true_surface *surface) RMAP_MUST_USE;

/* The same for a part of a file, either of whose names may be "": parts of one name are told apart
 * by their material. Where materials are wanted faces are called by them, if the file names parts.
 */
enum rmap_status rmap_mesh_builder_close_part(struct rmap_mesh_builder *builder, const char *name,
                                              const char *material) RMAP_MUST_USE;

/* Materials and parts, none yet, of the first n faces. RMAP_SYSTEM. */
enum rmap_status rmap_mesh_builder_fill_parts(struct rmap_mesh_builder *builder,
                                              size_t n) RMAP_MUST_USE;

/* The mesh, at its size. RMAP_INPUT when there is no triangle. */
enum rmap_status rmap_mesh_builder_finish(struct rmap_mesh_builder *builder,
                                          struct rmap_mesh **mesh_ret) RMAP_MUST_USE;
void rmap_mesh_builder_fini(struct rmap_mesh_builder *builder);

/* Of a file's bytes, behind which stands a 0, into a builder whose corners are scaled. RMAP_INPUT,
 * without the path, when they are none. Numbers are read in the calling thread's locale. */
enum rmap_status rmap_ply_read(const uint8_t *bytes, size_t nbytes, double scale,
                               struct rmap_mesh_builder *builder) RMAP_MUST_USE;
/* Buffers stand in files beside the path, or in the bytes. */
enum rmap_status rmap_gltf_read(const char *path, const uint8_t *bytes, size_t nbytes, double scale,
                                struct rmap_mesh_builder *builder) RMAP_MUST_USE;

#endif
