/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of the light that it registers: `response` and `detect`.
 */
#ifndef RMAP_SCENE_RESPONSE_H
#define RMAP_SCENE_RESPONSE_H

#include "io/scene/scene_reader.h"

/* node: the detector; of a scene whose sources are settled. */
void rmap_reader_response(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_detector *detector);

#endif
