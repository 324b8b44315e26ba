/* SPDX-License-Identifier: MIT
 *
 * Thin films: stacks of layers that coats of surfaces name.
 */
#ifndef RMAP_SCENE_FILMS_H
#define RMAP_SCENE_FILMS_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_films(struct rmap_reader *reader);

/* Complains of a film whose last layer may lie on either side of the object. */
void rmap_reader_check_films(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                             const struct rmap_object *object);

#endif
