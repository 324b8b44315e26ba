/* SPDX-License-Identifier: MIT
 *
 * Scatter models of surfaces.
 */
#ifndef RMAP_SCENE_SCATTER_H
#define RMAP_SCENE_SCATTER_H

#include "io/scene/scene_reader.h"

/* `reflect`, `transmit` or `scatter` of a surface whose other shares are read. */
void rmap_reader_read_scatter(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_surface *surface);

/* Complains of particles that may lie on either side of the object, and of `frame: uv` where it has
 * none. */
void rmap_reader_check_scatter(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                               const struct rmap_object *object);

#endif
