/* SPDX-License-Identifier: MIT
 *
 * A box along the world's axes, cut into equal voxels, and the parts of straight ways in each.
 */
#ifndef RMAP_VOXEL_GRID_H
#define RMAP_VOXEL_GRID_H

#include "analysis/detector/cell_sums.h"
#include "scene/scene.h"

struct rmap_voxel_grid {
    uint32_t n[3];
    double low[3], high[3], step[3]; /* in the scene's unit */
    double diagonal;                 /* of a voxel */
};

#define RMAP_VOXELS_MAX (1u << 26)

/* cells: "NXxNYxNZ", or one number for all three. region: "x0,y0,z0,x1,y1,z1", a unit of length at
 * the end if wanted; NULL: the box about the scene's objects. RMAP_USAGE with the remedy. */
enum rmap_status rmap_voxel_grid_read(const struct rmap_scene *scene, const char *cells,
                                      const char *region, struct rmap_voxel_grid *grid,
                                      struct rmap_error *err) RMAP_MUST_USE;

size_t rmap_voxel_grid_n(const struct rmap_voxel_grid *grid);

/* Voxel i + n[0] (j + n[1] k) that a point lies in; SIZE_MAX: outside. */
size_t rmap_voxel_grid_cell(const struct rmap_voxel_grid *grid, struct rmap_vec3 p);

/* Adds to each voxel weight times the length of the way from `from` to `to` in it, in diagonals of
 * a voxel. A walk from face to face (Amanatides and Woo, "A fast voxel traversal algorithm for ray
 * tracing", Eurographics 1987); faces are computed from their numbers, so that nothing adds up. */
void rmap_voxel_grid_walk(const struct rmap_voxel_grid *grid, struct rmap_vec3 from,
                          struct rmap_vec3 to, double weight, struct rmap_cell_sums *sums);

/* How far from a point all of the box lies at most. */
double rmap_voxel_grid_reach(const struct rmap_voxel_grid *grid, struct rmap_vec3 p);

#endif
