/* SPDX-License-Identifier: MIT
 *
 * Where gradient media stand: the frames of their index. rmap_scene_finish merges equal places and
 * drops those that nothing refers to.
 */
#ifndef RMAP_SCENE_FIELD_FRAMES_H
#define RMAP_SCENE_FIELD_FRAMES_H

#include "io/scene/scene_reader.h"

void rmap_reader_place_side(struct rmap_reader *reader, const struct rmap_object_side *side,
                            int32_t *gradient_ret);

void rmap_reader_settle_frames(struct rmap_reader *reader);

/* The place of the medium in which a source or camera stands, as far as the scene file says it
 * (`within`); 0: not, or uniform. */
void rmap_reader_place_within(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              int32_t medium, int32_t *gradient_ret);

#endif
