/* SPDX-License-Identifier: MIT
 *
 * Where things of a scene file stand, and the frames that follow from it.
 */
#ifndef RMAP_SCENE_PLACEMENT_H
#define RMAP_SCENE_PLACEMENT_H

#include "io/scene/scene_reader.h"

/* `at`, `rotate`, `scale`, `matrix`: a map from the item's frame to its parent's. */
bool rmap_reader_placement(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           struct rmap_affine *placement);

/* Unit x, y, z axes of a placement; orthogonal only if it has no shear. */
void rmap_placement_axes(const struct rmap_affine *placement, struct rmap_vec3 axis[3]);
/* The orthonormal frame that keeps the placement's z, origin and handedness. */
struct rmap_affine rmap_placement_rigid(const struct rmap_affine *placement);
/* Unit x and y of a plane whose unit normal is `axis`: x is the projection of the first world
 * axis (X, Y, Z) that is not within 26 degrees of it; y points along the world axis, of the other
 * two, that it is nearest to. Plain planes so have the world's own axes. */
void rmap_placement_plane(struct rmap_vec3 axis, struct rmap_vec3 *x, struct rmap_vec3 *y);

#endif
