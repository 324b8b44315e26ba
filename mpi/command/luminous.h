/* SPDX-License-Identifier: MIT
 *
 * Whether lm are asked for of sources in W.
 */
#ifndef RMAP_LUMINOUS_H
#define RMAP_LUMINOUS_H

#include "scene/scene.h"

/* By a quantity such as "illuminance"; NULL: no. V(lambda) makes lm of what the scene says of the
 * sources' spectra. RMAP_INPUT where it does not say them. */
enum rmap_status rmap_ask_luminous(const struct rmap_scene *scene, const char *quantity,
                                   bool *luminous_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
