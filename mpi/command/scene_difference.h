/* SPDX-License-Identifier: MIT
 *
 * Why a scene is not the one that a map was traced in.
 */
#ifndef RMAP_SCENE_DIFFERENCE_H
#define RMAP_SCENE_DIFFERENCE_H

#include "io/mesh/bundle.h"

/* The first thing that differs, as "line 12 of its text" or "--without"; leaves out what chooses
 * the colour space alone. */
void rmap_scene_difference(const struct rmap_bundle *of_map, const struct rmap_bundle *now,
                           char *text, size_t text_nbytes);

#endif
