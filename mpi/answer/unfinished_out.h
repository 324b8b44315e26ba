/* SPDX-License-Identifier: MIT
 *
 * What killed writers left in a map, as `info` and `verify` tell of it.
 */
#ifndef RMAP_UNFINISHED_OUT_H
#define RMAP_UNFINISHED_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "io/map/map_unfinished.h"

json_t *rmap_unfinished_json(const struct rmap_findings *files);
void rmap_unfinished_print(const struct rmap_findings *files, FILE *out);

#endif
