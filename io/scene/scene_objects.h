/* SPDX-License-Identifier: MIT
 *
 * The tree of objects: groups, instances, their surfaces and media.
 */
#ifndef RMAP_SCENE_OBJECTS_H
#define RMAP_SCENE_OBJECTS_H

#include "io/scene/scene_reader.h"

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
