/* SPDX-License-Identifier: MIT
 *
 * A triangle mesh in its own frame. Front side by the right-hand rule. Faces are the groups of
 * triangles that the file had (CAD faces, OBJ groups, materials): units of selection.
 */
#ifndef RMAP_MESH_H
#define RMAP_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"

struct rmap_mesh {
    size_t n_vertex, n_triangle, n_face;
    float (*vertex)[3];      /* [n_vertex] */
    uint32_t (*triangle)[3]; /* [n_triangle], vertex indices */
    uint32_t *face;          /* [n_triangle], face of each triangle, in [0, n_face) */
    char **face_name;        /* [n_face]; an entry may be NULL */
    float (*tangent)[3];     /* [n_triangle] unit vector along which the u of its texture grows; 0:
                                it has none. NULL: nobody asks */
};

/* Room for so many; contents zero. */
enum rmap_status rmap_mesh_create(size_t n_vertex, size_t n_triangle, size_t n_face,
                                  struct rmap_mesh **mesh_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_mesh_destroy(struct rmap_mesh *mesh); /* NULL is fine */

/* Axis-aligned bounds of the vertices; both 0 when there are none. */
void rmap_mesh_bounds(const struct rmap_mesh *mesh, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper);

/* Corners of a triangle in double. */
static inline void rmap_mesh_corners(const struct rmap_mesh *mesh, size_t triangle,
                                     struct rmap_vec3 corner[3])
{
    for (int k = 0; k < 3; k++) {
        const float *v = mesh->vertex[mesh->triangle[triangle][k]];
        corner[k] = rmap_vec3((double)v[0], (double)v[1], (double)v[2]);
    }
}

#endif
