/* SPDX-License-Identifier: MIT
 *
 * What every JSON document about a map says of it: whether it is all that was asked for.
 */
#ifndef RMAP_MAP_JSON_H
#define RMAP_MAP_JSON_H

#include <jansson.h>

#include "io/map/map_cut.h"
#include "io/map/map_reader.h"

/* Adds "complete", "rays_asked" (null: not known, as of a map of picked rays) and "rays_traced" to
 * the document, which is returned. NULL: memory is short, and the document is gone. */
json_t *rmap_json_of_map(json_t *document, const struct rmap_map *map);

/* Adds "until" where an answer is of a part of the map. NULL is fine. */
void rmap_json_add_part(json_t *document, const struct rmap_map_part *part);

#endif
