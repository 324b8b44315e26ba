/* SPDX-License-Identifier: MIT
 *
 * Sources dimmed after the trace: answers are as if each had so many times its flux. A ray is its
 * source's, and weights are shares of its flux, so nothing needs to be traced again.
 */
#ifndef RMAP_MAP_DIM_H
#define RMAP_MAP_DIM_H

#include <jansson.h>

#include "io/map/map_reader.h"

/* maintenance: of all sources, besides. factor: [n_source], 0 or more. From now on flux per weight
 * is that. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_map_dim(struct rmap_map *map, double maintenance, const double *factor,
                              struct rmap_error *err) RMAP_MUST_USE;

/* As it was traced. A map that is lent is so again when it is given back. */
void rmap_map_undim(struct rmap_map *map);

/* How many times its flux a source has, maintenance included; 1 where nothing was dimmed. */
double rmap_map_dimmed(const struct rmap_map *map, size_t source);

/* "maintenance factor 0.8; lamp x 0.5; without sky, sun"; "" where nothing was dimmed. */
#define RMAP_MAP_DIM_LEN 320
void rmap_map_dim_text(const struct rmap_map *map, char text[RMAP_MAP_DIM_LEN]);

/* Adds "maintenance" and "dim" {source: factor} where something was dimmed. NULL is fine. */
void rmap_json_add_dim(json_t *document, const struct rmap_map *map);

#endif
