/* SPDX-License-Identifier: MIT
 *
 * Named simulations, and what of the scene takes part.
 *
 * `only` (and a simulation's `objects`, `sources`, `detectors`) restricts each kind (objects,
 * sources, detectors) of which it names something; `without` then takes away.
 */
#ifndef RMAP_SCENE_SIMULATIONS_H
#define RMAP_SCENE_SIMULATIONS_H

#include "io/scene/scene_reader.h"

void rmap_reader_choose_simulation(struct rmap_reader *reader);

/* Changes the tree as `set:` of the chosen one says, before anything is read. */
enum rmap_status rmap_reader_set_simulation(struct rmap_reader *reader) RMAP_MUST_USE;

/* Reads all of them, and leaves out of a scene without mistakes what is not chosen. */
void rmap_reader_read_simulations(struct rmap_reader *reader);

#endif
