/* SPDX-License-Identifier: MIT
 *
 * A prescription as the text of a scene, as a person would write it.
 */
#ifndef RMAP_LENS_SCENE_H
#define RMAP_LENS_SCENE_H

#include <stdio.h>

#include "io/lensfile/lens_layout.h"

/* file: the name that the scene says it comes from. Errors of `out` are its owner's to find. */
void rmap_lens_scene_write(const struct rmap_lens_plan *plan, const char *file, FILE *out);

/* A name for the simulation that is its k-th configuration, from the file's own where it has one.
 */
void rmap_lens_configuration_name(const struct rmap_prescription *lens, int k, char *name,
                                  size_t cap);

/* What its beams fill: an element; NULL: they stand by themselves. */
const struct rmap_lens_element *rmap_lens_filled(const struct rmap_lens_plan *plan);

/* What stands in a line of that text, counted from 1. *at: index of the surface. False: nothing
 * that is a surface's alone. */
bool rmap_lens_scene_line(const struct rmap_lens_plan *plan, const char *text, int line,
                          size_t *at);

#endif
