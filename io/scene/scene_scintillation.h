/* SPDX-License-Identifier: MIT
 *
 * `scintillation:` of a medium.
 */
#ifndef RMAP_SCENE_SCINTILLATION_H
#define RMAP_SCENE_SCINTILLATION_H

#include "io/scene/scene_reader.h"

/* Where the medium has that key. */
void rmap_reader_scintillation(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_medium *medium);

#endif
