/* SPDX-License-Identifier: MIT
 *
 * Faces of a mesh: which ones are meant, and `faces:` of an object, which have surfaces, or media,
 * of their own; `by_face:`, whose faces are told apart. Such an object becomes a group of objects,
 * as a lens does.
 */
#ifndef RMAP_SCENE_FACES_H
#define RMAP_SCENE_FACES_H

#include "io/scene/scene_reader.h"

/* Marks the faces that a number, a range as in 0..3, a name (with * and ? a pattern), or a list of
 * these means; how many. quiet: what is not there is no mistake. */
size_t rmap_reader_mark_faces(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                              const struct rmap_mesh *mesh, bool quiet, uint8_t *face);

/* Instead of the object of the plan: NAME.FACES for each item of its `faces`, and for the rest of
 * its mesh NAME.body, or with `by_face` an object for each face. */
void rmap_reader_expand_faces(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              const struct rmap_object_plan *plan);

#endif
