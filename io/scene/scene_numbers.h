/* SPDX-License-Identifier: MIT
 *
 * The numbers of a scene as they were when a map was written: `/model/K` of the index, K the colour
 * space. Sines, powers and the like come from the C library, which differs between machines in the
 * last bit, and the text of the scene is read by programs of many versions; but what the compact
 * encoding leaves out must be computed from the very same bits for ever. So whoever decodes takes
 * them from here. They also let a reader do without a parser of scenes (examples/python).
 */
#ifndef RMAP_SCENE_NUMBERS_H
#define RMAP_SCENE_NUMBERS_H

#include "io/hdf5/h5.h"
#include "scene/scene.h"

/* Writes the group /model/K; /model must exist. */
enum rmap_status rmap_scene_numbers_write(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                          size_t space, struct rmap_error *err) RMAP_MUST_USE;

/* Puts the numbers of /model/K in the place of the scene's own. Kinds, counts and indices must be
 * those of the scene, and numbers finite: RMAP_FORMAT when they are not. */
enum rmap_status rmap_scene_numbers_read(struct rmap_h5 *h5, struct rmap_scene *scene, size_t space,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Whether two scenes have the same numbers, bit for bit; in one colour space. RMAP_SYSTEM. */
enum rmap_status rmap_scene_numbers_same(const struct rmap_scene *a, const struct rmap_scene *b,
                                         bool *same_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
