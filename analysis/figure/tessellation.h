/* SPDX-License-Identifier: MIT
 *
 * Every geometry as a triangle mesh with shared vertices, for drawing: analytic surfaces are
 * tessellated, meshes welded. Never used to trace.
 */
#ifndef RMAP_TESSELLATION_H
#define RMAP_TESSELLATION_H

#include "geometry/mesh.h"
#include "geometry/shape.h"

/* Facets around an axis: a multiple of 4, so that sections through the axis meet vertices and
 * show true profiles. */
#define RMAP_FACETS 96

/* In the shape's own frame, counter-clockwise about its normal. Vertices of a surface of revolution
 * lie ring by ring along its profile, RMAP_FACETS to a ring, the first of each at y = 0. */
enum rmap_status rmap_shape_tessellate(const struct rmap_shape *shape, struct rmap_mesh **mesh_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* A copy in which vertices at the same place are one; face names are left behind. */
enum rmap_status rmap_mesh_weld(const struct rmap_mesh *mesh, struct rmap_mesh **mesh_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
