/* SPDX-License-Identifier: MIT
 *
 * Commands that ask maps can be given a scene: its first rays are traced into memory for them.
 */
#ifndef RMAP_SCENE_AS_MAP_H
#define RMAP_SCENE_AS_MAP_H

#include "io/map/map_reader.h"
#include "mpi/command/load.h"

/* What -n and --cache of such a command are in its option table. */
#define RMAP_SCENE_RAYS_OPTION(n)                                                                  \
    {"rays", 'n', "RAYS", "of a scene in place of a map: trace so many (default " #n ")"},         \
        RMAP_CACHE_OPTION

/* Collective. The map at a path, or, where that ends in .yaml or .yml, one of the scene's rays
 * [0, -n), of seed 1 as `raymap trace` has it. n_ray: without -n; of a scene without sources 0.
 * RMAP_USAGE: -n with a map, or too many rays for memory. */
enum rmap_status rmap_load_map_or_scene(const struct rmap_context *context,
                                        const struct rmap_arguments *given, const char *path,
                                        uint64_t n_ray, struct rmap_map **map_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
