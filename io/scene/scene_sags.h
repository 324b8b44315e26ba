/* SPDX-License-Identifier: MIT
 *
 * Surfaces that are no conics with even powers: the keys that make a SAG, as numbers.
 */
#ifndef RMAP_SCENE_SAGS_H
#define RMAP_SCENE_SAGS_H

#include "io/scene/scene_reader.h"

/* Does one of the keys of a `conic` or a lens's row ask for a SAG? */
bool rmap_reader_is_sag(const struct rmap_yaml_node *map);
bool rmap_reader_sag(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                     struct rmap_shape *shape);

/* 1 / a radius; 0 for 0 or `inf`. */
bool rmap_reader_radius(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *what, double *curvature);

/* {power: coefficient, ...}, of powers that are multiples of `step` up to `most`:
 * coefficient[power / step - 1]. *n_ret: entries in use. */
bool rmap_reader_powers(struct rmap_reader *reader, const struct rmap_yaml_node *node, int step,
                        int most, double *coefficient, int *n_ret);

#endif
