/* SPDX-License-Identifier: MIT
 *
 * A scene with rays as glTF: bodies with materials by what their surfaces do, in metres, y upwards;
 * rays as lines, a node for each group of their paint.
 */
#ifndef RMAP_SCENE_GLB_H
#define RMAP_SCENE_GLB_H

#include "analysis/figure/ray_paint.h"
#include "io/map/map_reader.h"

/* rays: all columns. path: binary, or JSON where it ends in .gltf; replaced when
 * the whole is written. Points of curved segments are those that
 * were recorded. RMAP_SYSTEM. */
enum rmap_status rmap_scene_glb_write(const struct rmap_map *map, const struct rmap_portion *rays,
                                      const struct rmap_ray_paint *paint, const char *path,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
