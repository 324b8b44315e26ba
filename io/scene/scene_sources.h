/* SPDX-License-Identifier: MIT
 *
 * Sources of light.
 */
#ifndef RMAP_SCENE_SOURCES_H
#define RMAP_SCENE_SOURCES_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_sources(struct rmap_reader *reader);

/* {mesh: NAME}, the shape of what sends light. */
void rmap_reader_mesh_shape(struct rmap_reader *reader, const struct rmap_yaml_node *shape,
                            struct rmap_source *source);

/* `air`, `vacuum`, or what most objects stand in; else a vacuum is made. */
void rmap_reader_surrounding_medium(struct rmap_reader *reader, int32_t *medium_ret);

#endif
