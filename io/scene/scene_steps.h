/* SPDX-License-Identifier: MIT
 *
 * Sources whose light charged particles make along their steps.
 */
#ifndef RMAP_SCENE_STEPS_H
#define RMAP_SCENE_STEPS_H

#include "io/scene/scene_reader.h"

/* `type: steps`: place, and the steps of its file in its frame. */
void rmap_reader_read_steps(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_source *source);

/* Once its medium and its place in the world are known. */
void rmap_reader_settle_steps(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_source *source);

#endif
