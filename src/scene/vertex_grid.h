/* SPDX-License-Identifier: MIT
 *
 * The vertices of a mesh by the cells of a grid over its box: how far it reaches along an axis of
 * the world is found from those of a few cells. For meshes with many instances.
 */
#ifndef RMAP_VERTEX_GRID_H
#define RMAP_VERTEX_GRID_H

#include "scene/bounds.h"

struct rmap_vertex_grid;

/* NULL when memory is short. */
struct rmap_vertex_grid *rmap_vertex_grid_create(const struct rmap_mesh *mesh);
void rmap_vertex_grid_destroy(struct rmap_vertex_grid *grid); /* NULL is fine */

/* What rmap_bounds_include_geometry makes of the mesh, to the last digit; false: of numbers
 * this large only that can tell. */
bool rmap_vertex_grid_bounds(const struct rmap_vertex_grid *grid,
                             const struct rmap_affine *to_world, struct rmap_bounds *bounds_ret);

#endif
