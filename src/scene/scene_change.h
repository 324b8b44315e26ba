/* SPDX-License-Identifier: MIT
 *
 * What a ray notices of the difference between two scenes: for who keeps those rays of the old one
 * that the new one has, too.
 *
 * A ray of the old scene is a ray of the new one if it starts alike, meets nothing that has another
 * surface, shape or place, runs in no medium with other numbers, and passes no place where
 * something stood or stands that the search for the next surface, or a detector, may see. All
 * random numbers are of the ray's own number and step, so that nothing else of the scene matters.
 */
#ifndef RMAP_SCENE_CHANGE_H
#define RMAP_SCENE_CHANGE_H

#include "scene/scene.h"

#define RMAP_CHANGE_TEXT_LEN 160

struct rmap_scene_change {
    char all[RMAP_CHANGE_TEXT_LEN]; /* why every ray is another; "": not every one is */
    /* Numbers of the new scene, by those of the old; -1: gone. What is left stands in the old
     * order. */
    int32_t *object, *medium, *detector;
    /* Of the old scene, 1: a ray is another that meets the object, runs in the medium, is noted by
     * the detector. */
    uint8_t *met, *in, *noted;
    /* 1: its place is looked at, [objects of the old], [of the new], [detectors of the new]. */
    uint8_t *stood, *stands, *watches;
    bool leaving;     /* every ray that leaves the scene is another */
    bool same_sphere; /* the bounding sphere is the same */
    bool renumbers;   /* some numbers are others */
};

/* RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_scene_change_find(const struct rmap_scene *old, const struct rmap_scene *new,
                                        struct rmap_scene_change *change,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_scene_change_fini(struct rmap_scene_change *change); /* zeroed: fine */

/* Marks of one scene's objects (stood, stands) have come to more: the other's, and who is met, are
 * brought in line. */
void rmap_scene_change_settle(const struct rmap_scene *old, struct rmap_scene_change *change);

#endif
