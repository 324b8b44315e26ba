/* SPDX-License-Identifier: MIT
 *
 * What an import found: for people, and as JSON.
 */
#ifndef RMAP_LENS_OUT_H
#define RMAP_LENS_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "io/lensfile/lens_layout.h"

/* path: of the lens file; scene: of what was written. */
void rmap_lens_print(const struct rmap_lens_plan *plan, const char *scene, FILE *out);
json_t *rmap_lens_json(const struct rmap_lens_plan *plan, const char *path, const char *scene);

#endif
