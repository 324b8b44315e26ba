/* SPDX-License-Identifier: MIT
 *
 * Media that scatter by more than a coefficient and a mean cosine, or give light back.
 */
#ifndef RMAP_SCENE_TURBID_H
#define RMAP_SCENE_TURBID_H

#include "io/scene/scene_reader.h"

/* Whether `scattering` of a medium is a mapping of its own, not a quantity. */
bool rmap_reader_is_scattering(const struct rmap_yaml_node *scattering);

/* Once the indices of all media stand: those mappings, and species. */
void rmap_reader_read_turbid(struct rmap_reader *reader);

#endif
