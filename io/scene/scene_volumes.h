/* SPDX-License-Identifier: MIT
 *
 * Sources that shine from within a body, along a track, or from the cells of a grid.
 */
#ifndef RMAP_SCENE_VOLUMES_H
#define RMAP_SCENE_VOLUMES_H

#include "io/scene/scene_reader.h"

/* `type: volume`. */
void rmap_reader_read_volume(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct rmap_source *source);

#endif
