/* SPDX-License-Identifier: MIT
 *
 * Colours of objects where they are drawn: what their fronts throw back of white light.
 */
#ifndef RMAP_OBJECT_COLOUR_H
#define RMAP_OBJECT_COLOUR_H

#include "scene/scene.h"

/* Linear RGB of each object, 0 to 1, of light that falls straight on it. [n_object], the caller
 * frees it; NULL: out of memory. */
double (*rmap_object_colours(const struct rmap_scene *scene))[3];

/* Has it a hue to speak of? */
bool rmap_colour_has_hue(const double linear[3]);

/* Face in full light on white paper (sRGB, 0 to 1), and "#rrggbb" of its outline; glass and
 * surfaces without a hue have the ink of their look. */
void rmap_object_tint(enum rmap_look look, const double linear[3], double tint[3]);
void rmap_object_ink(enum rmap_look look, const double linear[3], char ink[8]);

#endif
