/* SPDX-License-Identifier: MIT
 *
 * Light that passes and that is absorbed in the voxels of a box: a kind of fold.
 */
#ifndef RMAP_VOXEL_SUMS_H
#define RMAP_VOXEL_SUMS_H

#include "analysis/detector/voxel_grid.h"
#include "analysis/query/fold.h"

enum rmap_voxel_what {
    RMAP_VOXEL_PASSING,  /* weight times way, in diagonals of a voxel */
    RMAP_VOXEL_ABSORBED, /* weight, in media */
    RMAP_VOXEL_SURFACES, /* weight, on surfaces */
    RMAP_VOXEL_PARTS
};

struct rmap_voxel_ask {
    const struct rmap_map *map; /* borrowed */
    struct rmap_voxel_grid grid;
};

struct rmap_voxel_sums {
    const struct rmap_voxel_ask *ask; /* borrowed */
    struct rmap_cell_sums part[RMAP_VOXEL_PARTS];
};

/* The context is a struct rmap_voxel_ask; states are struct rmap_voxel_sums. RMAP_USAGE from
 * `create` when they would take too much memory. */
extern const struct rmap_fold_kind rmap_voxel_kind;
rmap_column_set rmap_voxel_columns(const struct rmap_scene *scene);

#endif
