/* SPDX-License-Identifier: MIT
 *
 * Of the numbers of a scene (scene_numbers.h) those of the SAG and WALL shapes: a row for each sag,
 * shape after shape; of a wall first the bottom, then the top.
 */
#ifndef RMAP_SAG_NUMBERS_H
#define RMAP_SAG_NUMBERS_H

#include "geometry/sag.h"
#include "io/hdf5/h5.h"
#include "scene/scene.h"

struct rmap_kept_sag {
    int32_t geometry, side;
    struct rmap_aperture outline;
    struct rmap_sag sag;
};

enum { RMAP_KEPT_SAG_FIELDS = 24 };
extern const struct rmap_h5_field rmap_kept_sag_field[RMAP_KEPT_SAG_FIELDS];

size_t rmap_kept_sag_count(const struct rmap_scene *scene);
void rmap_kept_sag_copy(const struct rmap_scene *scene, struct rmap_kept_sag *kept);

/* Into the scene, with what follows from them: NULL, or what is wrong with them. */
const char *rmap_kept_sag_back(const struct rmap_kept_sag *kept, struct rmap_scene *scene);

#endif
