/* SPDX-License-Identifier: MIT
 *
 * Which rays a map holds, and which it was asked for.
 */
#ifndef RMAP_MAP_RAYS_H
#define RMAP_MAP_RAYS_H

#include "io/map/map_content.h"
#include "io/map/map_reader.h"
#include "portion/ray_plan.h"

/* Those that a run was asked for, up to RMAP_RAY_END. */
struct rmap_ray_range rmap_run_rays(const struct rmap_run_row *run);

/* Ids that a content holds; those that a map's runs were asked for. Into an empty set. */
enum rmap_status rmap_rays_held(const struct rmap_map_content *content, struct rmap_ray_set *set,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_rays_wanted(const struct rmap_map *map, struct rmap_ray_set *set,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* How many rays a map's runs were asked for. False: not known, as of picked rays. */
bool rmap_rays_asked(const struct rmap_map *map, uint64_t *n_ret);

/* It holds all rays that were asked for; of picked rays also the map that they were picked from. */
bool rmap_map_is_whole(const struct rmap_map *map);

#endif
