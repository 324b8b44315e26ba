/* SPDX-License-Identifier: MIT
 *
 * Lamps by their maker's files.
 */
#ifndef RMAP_SCENE_LAMPS_H
#define RMAP_SCENE_LAMPS_H

#include "io/scene/scene_reader.h"
#include "io/scene/scene_source_light.h"

/* `file`, `set`, `emitter` and `spin` of a source whose frame is read; its flux is the file's where
 * the scene says none. */
void rmap_reader_read_lamp(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source *source, struct rmap_source_light *light);

/* `distribution: {table: FILE}` of a point, which becomes a lamp, or of an area. */
void rmap_reader_distribution_file(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                   const char *key, struct rmap_source *source,
                                   struct rmap_source_light *light);

#endif
