/* SPDX-License-Identifier: MIT
 *
 * Beams: Gaussian ones, and collimated ones that are not as bright all over.
 */
#ifndef RMAP_SCENE_BEAMS_H
#define RMAP_SCENE_BEAMS_H

#include "io/scene/scene_reader.h"

/* `type: beam`, but its place. */
void rmap_reader_read_beam(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source *source);

/* `profile` of a collimated source: {gaussian: radius} or {radius: [...], value: [...]}. */
void rmap_reader_read_profile(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_source *source);

#endif
