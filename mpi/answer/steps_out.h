/* SPDX-License-Identifier: MIT
 *
 * What light the steps of particles make, for `raymap check`.
 */
#ifndef RMAP_STEPS_OUT_H
#define RMAP_STEPS_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "scene/scene.h"

/* Behind the flux of a source of steps; of all of them as JSON, NULL: there are none. */
void rmap_steps_print(const struct rmap_steps *steps, FILE *out);
json_t *rmap_steps_json(const struct rmap_scene *scene);

#endif
