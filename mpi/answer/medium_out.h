/* SPDX-License-Identifier: MIT
 *
 * What the media of a scene scatter, for `raymap check`.
 */
#ifndef RMAP_MEDIUM_OUT_H
#define RMAP_MEDIUM_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "scene/scene.h"

/* The scene's scattering media: at one wavelength as text, at all of them as JSON. */
void rmap_turbid_print(const struct rmap_scene *scene, FILE *out);
json_t *rmap_turbid_json(const struct rmap_scene *scene);

#endif
