/* SPDX-License-Identifier: MIT
 *
 * Edges at which a mesh is open.
 */
#ifndef RMAP_MESH_EDGES_H
#define RMAP_MESH_EDGES_H

#include "geometry/mesh.h"

/* An edge of a triangle, from its lesser vertex; turn: 1 or -1 as the triangle runs along it. */
struct rmap_mesh_edge {
    uint32_t from, to;
    int turn;
};

/* How many edges triangles do not run along as often in one direction as in the other; *first_ret:
 * one of them. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_mesh_open_edges(const struct rmap_mesh *mesh, size_t *n_ret,
                                      struct rmap_mesh_edge *first_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
