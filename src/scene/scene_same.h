/* SPDX-License-Identifier: MIT
 *
 * Whether parts of two scenes are alike for every ray, bit for bit. "Not alike" may be said of
 * parts that are, where nobody compares what they own; never the other way round.
 */
#ifndef RMAP_SCENE_SAME_H
#define RMAP_SCENE_SAME_H

#include "scene/scene.h"

/* A scene, and a later one of as many channels. */
struct rmap_scene_pair {
    const struct rmap_scene *old, *new;
    const int32_t *medium; /* [old->n_medium] number of the same name in the new one; -1: none */
};

/* By number, old and new; media as numbers of the pair, negative ones (any) included. */
bool rmap_same_medium_number(const struct rmap_scene_pair *pair, int32_t old, int32_t new);
bool rmap_same_medium(const struct rmap_scene_pair *pair, int32_t old, int32_t new);
bool rmap_same_surface(const struct rmap_scene_pair *pair, int32_t old, int32_t new);
bool rmap_same_geometry(const struct rmap_scene_pair *pair, int32_t old, int32_t new);

/* Texture coordinates are not looked at. */
bool rmap_same_mesh(const struct rmap_mesh *a, const struct rmap_mesh *b);

/* Emits the same rays, its medium's numbers aside; whatever its flux is. */
bool rmap_same_source(const struct rmap_scene_pair *pair, size_t old, size_t new);

/* Whether sources of its kind are compared at all. */
bool rmap_source_is_compared(const struct rmap_source *source);

/* Registers the same light where that comes to it; what it lies on is not looked at. */
bool rmap_same_detector(const struct rmap_detector *old, const struct rmap_detector *new);

#endif
