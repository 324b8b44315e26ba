/* SPDX-License-Identifier: MIT
 *
 * Gradient media are asked for an index on the surfaces that bound them, and inside closed bodies,
 * before light is: a scene whose medium has none there is told of it with the place.
 */
#ifndef RMAP_SCENE_FIELD_PROBE_H
#define RMAP_SCENE_FIELD_PROBE_H

#include "io/scene/scene_reader.h"

/* Once the scene is finished: mistakes of gradient media that show where they are. */
void rmap_reader_probe_gradients(struct rmap_reader *reader);

/* The same: warns of objects in them that light may pass unseen. */
void rmap_reader_probe_sag(struct rmap_reader *reader);

#endif
