/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of events: `reading`.
 */
#ifndef RMAP_SCENE_READING_H
#define RMAP_SCENE_READING_H

#include "io/scene/scene_reader.h"

/* node: the detector. */
void rmap_reader_reading(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_detector *detector);

#endif
