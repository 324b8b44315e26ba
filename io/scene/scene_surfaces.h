/* SPDX-License-Identifier: MIT
 *
 * Surfaces: what happens to light that meets one.
 */
#ifndef RMAP_SCENE_SURFACES_H
#define RMAP_SCENE_SURFACES_H

#include "io/scene/scene_reader.h"

/* `key`: a surface's name or {front: a, back: b}; untouched when absent. NULL: the names are only
 * looked up. */
void rmap_reader_surface_pair(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                              const char *key, int32_t *front_ret, int32_t *back_ret);
void rmap_reader_builtin_surface(struct rmap_reader *reader, enum rmap_surface_type type,
                                 int32_t *surface_ret);

void rmap_reader_read_surfaces(struct rmap_reader *reader);

#endif
