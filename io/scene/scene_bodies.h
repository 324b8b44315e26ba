/* SPDX-License-Identifier: MIT
 *
 * Closed bodies: `box` and `prism`, which become meshes, and tubes with caps, which stay exact.
 */
#ifndef RMAP_SCENE_BODIES_H
#define RMAP_SCENE_BODIES_H

#include "io/scene/scene_reader.h"

/* NULL after a complaint. The caller's. */
struct rmap_mesh *rmap_reader_box(struct rmap_reader *reader, const struct rmap_yaml_node *node);
struct rmap_mesh *rmap_reader_prism(struct rmap_reader *reader, const struct rmap_yaml_node *node);

/* The discs that close a tube, 0 for an end without one, as geometries of the scene. */
void rmap_reader_add_caps(struct rmap_reader *reader, const struct rmap_shape *tube,
                          struct rmap_geometry_entry *entry);

/* An instance of a closed tube: a group of `side`, `bottom`, `top`. */
void rmap_reader_expand_closed(struct rmap_reader *reader, const struct rmap_geometry_entry *entry,
                               const struct rmap_object_plan *plan);

#endif
