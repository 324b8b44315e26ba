/* SPDX-License-Identifier: MIT
 *
 * What an index says of the scene: its text and meshes, the names of what columns count, and its
 * light.
 */
#ifndef RMAP_INDEX_SCENE_H
#define RMAP_INDEX_SCENE_H

#include "io/h5.h"
#include "io/map_writer.h"

/* emitted: [sources] rays that each source's flux is shared out over. */
enum rmap_status rmap_index_scene_write(struct rmap_h5 *h5, const struct rmap_run *run,
                                        const double *emitted,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
