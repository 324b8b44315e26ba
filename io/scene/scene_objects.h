/* SPDX-License-Identifier: MIT
 *
 * The tree of objects: groups, instances, their surfaces and media.
 */
#ifndef RMAP_SCENE_OBJECTS_H
#define RMAP_SCENE_OBJECTS_H

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

void rmap_reader_read_objects(struct rmap_reader *reader);

void rmap_reader_add_object(struct rmap_reader *reader, const struct rmap_object_plan *plan);

/* `front` `back` `inside` `outside` of a mapping, beside the sides that the plan has already;
 * complains where the plan's surfaces let light through and a side has no medium. */
void rmap_reader_sides(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_object_plan *plan);

void rmap_reader_add_group(struct rmap_reader *reader, const char *name,
                           const struct rmap_yaml_node *node, int32_t parent,
                           const struct rmap_affine *to_world, const struct rmap_affine *placement,
                           bool derived, int32_t *group_ret);

#endif
