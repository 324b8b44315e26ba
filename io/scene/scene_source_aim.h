/* SPDX-License-Identifier: MIT
 *
 * Collimated sources that say what they fill instead of where they stand.
 */
#ifndef RMAP_SCENE_SOURCE_AIM_H
#define RMAP_SCENE_SOURCE_AIM_H

#include "io/scene/scene_reader.h"

/* `fills` and `field` of the source's node, once all objects are known: its shape, a disc, and its
 * frame. False where the node has no `fills`. */
bool rmap_reader_aim_source(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_source *source);

#endif
