/* SPDX-License-Identifier: MIT
 *
 * The rays that a map keeps by name, as `select` and `info` tell of them.
 */
#ifndef RMAP_NAMED_RAYS_OUT_H
#define RMAP_NAMED_RAYS_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "io/map/named_rays.h"

/* A list of objects; NULL: memory was short. */
json_t *rmap_named_rays_json(const struct rmap_named_rays_list *list);

/* A line each, or, where there is none and a map's path is given, one that says so. */
void rmap_named_rays_print(const char *path, const struct rmap_named_rays_list *list, FILE *out);

#endif
