/* SPDX-License-Identifier: MIT
 *
 * Species in a medium: what absorbs light and gives some of it back at other wavelengths.
 */
#ifndef RMAP_SCENE_SPECIES_H
#define RMAP_SCENE_SPECIES_H

#include "io/scene/scene_reader.h"

/* `species` and `accounting` of a medium's mapping, where they stand. */
void rmap_reader_species(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_medium *medium);

/* Warns where light given back weighs more than a ray's weight can. After rmap_scene_finish. */
void rmap_reader_check_worth(struct rmap_reader *reader);

#endif
