/* SPDX-License-Identifier: MIT
 *
 * Boxes of a scene's objects in the world, kept for later starts (kept_file.h): of scenes of many
 * instances they are a third of what is left to do.
 */
#ifndef RMAP_SCENE_BOXES_H
#define RMAP_SCENE_BOXES_H

#include "io/file/kept_file.h"
#include "io/scene/scene_reader.h"

struct rmap_boxes {
    struct rmap_kept kept; /* of the meshes and places of the scene's objects; no path: not kept */
    uint8_t *bytes;        /* as they were read; NULL: they are to be kept */
};

/* Before rmap_scene_finish, which takes them over where they are kept. */
void rmap_boxes_find(struct rmap_reader *reader, struct rmap_boxes *boxes);

/* Behind it, which said `finished`: keeps them, and frees what boxes has. */
void rmap_boxes_keep(struct rmap_reader *reader, enum rmap_status finished,
                     struct rmap_boxes *boxes);

#endif
