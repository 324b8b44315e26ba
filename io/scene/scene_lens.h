/* SPDX-License-Identifier: MIT
 *
 * `lens`: the table of a prescription.
 */
#ifndef RMAP_SCENE_LENS_H
#define RMAP_SCENE_LENS_H

#include "io/scene/scene_reader.h"

/* The table of a `lens`; leaves entry broken when it is wrong. */
void rmap_reader_read_lens(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_geometry_entry *entry);

/* An instance of a prescription: a group and its surfaces, edges and stop. The plan's surfaces
 * are those of the caps. */
void rmap_reader_expand_lens(struct rmap_reader *reader, const struct rmap_geometry_entry *entry,
                             const struct rmap_object_plan *plan, int32_t outside);

#endif
