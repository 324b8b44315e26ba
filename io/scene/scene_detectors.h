/* SPDX-License-Identifier: MIT
 *
 * Virtual detectors: planes free in space or lying on an object, and far-field grids.
 */
#ifndef RMAP_SCENE_DETECTORS_H
#define RMAP_SCENE_DETECTORS_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_detectors(struct rmap_reader *reader);

void rmap_reader_read_receivers(struct rmap_reader *reader);

#endif
