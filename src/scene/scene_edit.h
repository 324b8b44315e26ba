/* SPDX-License-Identifier: MIT
 *
 * A scene in memory in which something is moved, turned or scaled: as if it had been read with that
 * there, without a look at all the rest. Every other change makes another scene, read anew, for
 * which rmap_accel_create_like takes over what it has of the old one.
 */
#ifndef RMAP_SCENE_EDIT_H
#define RMAP_SCENE_EDIT_H

#include "scene/scene.h"

/* An object, or a group with all that is below it; the other one is -1. */
struct rmap_scene_part {
    int32_t object, group;
};

/* By its name; false: there is none. */
bool rmap_scene_part_find(const struct rmap_scene *scene, const char *name,
                          struct rmap_scene_part *part);

/* The frame that the `at` of an object, a group or a source is in: that of the group that has it;
 * the world's for all else. */
struct rmap_affine rmap_scene_frame_of(const struct rmap_scene *scene, const char *name);

/* Can it be moved alone? Not where its place is its group's, or where more than objects hangs on
 * it: sources and detectors in it or on it, a source that fills some object, light of a volume or a
 * sky, gradient media. Then the scene is to be read anew. */
bool rmap_scene_part_is_movable(const struct rmap_scene *scene, struct rmap_scene_part part);

/* What a scene file's `scale`, `rotate` and `at` make: rmap_affine_placement. A part of a
 * finished scene gets another placement in its group. *object_ret, owned by the caller: the objects
 * that stand elsewhere, for rmap_accel_move. RMAP_INPUT, and the scene is as it was: no inverse, or
 * too large; RMAP_USAGE: it is not movable. */
enum rmap_status rmap_scene_move(struct rmap_scene *scene, struct rmap_scene_part part,
                                 const struct rmap_affine *placement, int32_t **object_ret,
                                 size_t *n_object_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
