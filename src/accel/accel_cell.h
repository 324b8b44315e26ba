/* SPDX-License-Identifier: MIT
 *
 * Meshes whose faces lie on true surfaces. A triangle stands for a cell of its face's surface: what
 * lies between three planes, one through each of its edges and square to the surface there. A ray
 * meets the surface, not the triangle, and which cell it meets says to which face the point
 * belongs. Within a face cells overlap a little, since a point of one surface is the same for all
 * of them. Where two surfaces meet
 *
 * - at an angle, each ends where the other begins: at their true edge, whose chord the triangles
 *   have. In a strip about the chord, as wide as the edge may be from it, a point of the one counts
 *   on one side of the other. A line so enters and leaves a body by turns.
 * - smoothly, the plane through the chord divides them, and the point of the first of the two
 *   decides for both, as they differ by less than the strip's width squared.
 *
 * Triangles without a true surface are planes, which end at true surfaces in the same way, and at
 * one another as src/accel/accel_triangle.h says.
 */
#ifndef RMAP_ACCEL_CELL_H
#define RMAP_ACCEL_CELL_H

#include "accel/accel_internal.h"

/* Where a cell ends. */
enum rmap_brink {
    RMAP_BRINK_OPEN,   /* nothing follows */
    RMAP_BRINK_SAME,   /* a cell of the same surface */
    RMAP_BRINK_FLAT,   /* a plain triangle next to a plain triangle */
    RMAP_BRINK_SHARP,  /* another surface */
    RMAP_BRINK_SMOOTH, /* another one, tangent to this one */
};

struct rmap_cell_edge {
    double plane[4]; /* distance of p: plane . (p, 1), > 0 inside */
    double width;    /* of the strip on either side */
    int32_t across;  /* surface that follows; -1: none */
    int8_t brink;
    int8_t sign; /* SHARP: of the distance from that surface, inside */
};

struct rmap_cells {
    struct rmap_mesh whole;            /* with what lies beyond */
    const struct rmap_mesh *mesh;      /* that */
    struct rmap_true_surface *surface; /* of faces, then of each plain triangle */
    int32_t *its;                      /* [n_triangle] surface, the first of those that are one */
    struct rmap_cell_edge (*edge)[3];  /* [n_triangle], from corner k to the next */
    float (*box)[6];                   /* [n_triangle] lower, upper */
    uint32_t *first, *near; /* edges of other cells that end at corners of this one: 3 triangle + k,
                               near[first[i]] ... */
};

/* facets: of the mesh, built. wider: by which boxes exceed what they hold. */
enum rmap_status rmap_cells_build(const struct rmap_mesh *mesh, const struct rmap_facets *facets,
                                  double wider, struct rmap_cells **cells_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_cells_destroy(struct rmap_cells *cells);

/* Surface of a triangle, and is it one beyond the triangle itself? */
static inline const struct rmap_true_surface *rmap_cell_surface(const struct rmap_cells *cells,
                                                                int32_t primitive)
{
    return &cells->surface[cells->its[primitive]];
}

static inline bool rmap_cell_is_true(const struct rmap_cells *cells, int32_t primitive)
{
    return (size_t)cells->its[primitive] < cells->mesh->n_face;
}

/* Does the point, which the query's ray meets at t, belong to the cell? local: the ray is in the
 * mesh's frame. */
bool rmap_cell_holds(const struct rmap_query *query, int32_t object, int32_t primitive, double t,
                     struct rmap_vec3 point);

/* Is the point where the ray started, on a surface that goes smoothly on into this one? normal: of
 * this one. */
bool rmap_cell_is_start(const struct rmap_query *query, int32_t object, int32_t primitive,
                        struct rmap_vec3 point, struct rmap_vec3 normal);

#endif
