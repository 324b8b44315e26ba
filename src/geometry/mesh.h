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
#include "formula/true_surface.h"

/* Texture coordinates beyond are none: cells are counted in whole numbers. */
#define RMAP_MESH_UV_FARTHEST 1e6f

struct rmap_mesh {
    size_t n_vertex, n_triangle, n_face;
    float (*vertex)[3];      /* [n_vertex] */
    uint32_t (*triangle)[3]; /* [n_triangle], vertex indices */
    uint32_t *face;          /* [n_triangle], face of each triangle, in [0, n_face) */
    char **face_name;        /* [n_face]; an entry may be NULL */
    float (*tangent)[3];     /* [n_triangle] unit vector along which the u of its texture grows; 0:
                                it has none. NULL: nobody asks */
    float (*uv)[6]; /* [n_triangle] texture coordinates u, v of its corners, v upwards; all 0: it
                       has none. NULL: nobody asks */
    struct rmap_true_surface *surface; /* [n_face] that the triangles of each face approximate, of
                                          kind NONE where they are all there is. NULL: of none */
    /* Of a part of a mesh with true surfaces: so many more stand behind the arrays, of what lies
     * beyond its rim, as surfaces end at each other. They are not of the part. */
    size_t n_vertex_beyond, n_triangle_beyond, n_face_beyond;
    int n_more; /* holders beside the first */
};

/* Room for so many; contents zero. */
enum rmap_status rmap_mesh_create(size_t n_vertex, size_t n_triangle, size_t n_face,
                                  struct rmap_mesh **mesh_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
/* One more holder, of a mesh that nobody changes any more; not for threads at once. */
struct rmap_mesh *rmap_mesh_hold(struct rmap_mesh *mesh);
void rmap_mesh_destroy(struct rmap_mesh *mesh); /* the last holder's frees it; NULL is fine */

/* Sets its frame from its axis, which is of length 1. NULL when the numbers make a surface, else
 * what is wrong with them. rmap_mesh_share_surfaces: faces that lie on one surface get the same
 * numbers. */
const char *rmap_true_surface_finish(struct rmap_true_surface *surface);
enum rmap_status rmap_mesh_share_surfaces(struct rmap_mesh *mesh,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The mesh with what lies beyond; it owns nothing. */
static inline struct rmap_mesh rmap_mesh_with_beyond(const struct rmap_mesh *mesh)
{
    struct rmap_mesh whole = *mesh;
    whole.n_vertex += mesh->n_vertex_beyond;
    whole.n_triangle += mesh->n_triangle_beyond;
    whole.n_face += mesh->n_face_beyond;
    return whole;
}

/* The true surface of a triangle; NULL: itself. */
static inline const struct rmap_true_surface *rmap_mesh_surface(const struct rmap_mesh *mesh,
                                                                size_t triangle)
{
    const struct rmap_true_surface *surface =
        mesh->surface ? &mesh->surface[mesh->face[triangle]] : NULL;
    return surface && surface->kind != RMAP_TRUE_NONE ? surface : NULL;
}

/* Puts a point of the triangle onto its true surface, where it has one, and turns its normal to
 * that of the surface. */
void rmap_mesh_lift(const struct rmap_mesh *mesh, size_t triangle, struct rmap_vec3 *point,
                    struct rmap_vec3 *normal);

/* How far a triangle's true surface may lie from it. */
double rmap_mesh_bulge(const struct rmap_mesh *mesh, size_t triangle);

/* Axis-aligned bounds, those of the vertices but for true surfaces; both 0 when there are none. */
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
