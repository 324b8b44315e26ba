/* SPDX-License-Identifier: MIT
 *
 * The light of a map as rays that go on from a detector: as those of a source of another scene, or
 * of a file.
 */
#ifndef RMAP_MAP_LIGHT_H
#define RMAP_MAP_LIGHT_H

#include "io/map/map_reader.h"
#include "io/rays/ray_write.h"

/* What reads a ray for the next two. */
rmap_column_set rmap_map_light_columns(const struct rmap_scene *scene);

/* Registration `row` of the ray in row `ray`, whose segments begin at `first`, as it goes on from
 * there; the n-th of all. space: the portion's colour space. */
void rmap_map_light_at(const struct rmap_map *map, size_t space, const struct rmap_portion *portion,
                       size_t ray, size_t first, size_t row, uint64_t n,
                       struct rmap_ray_written *out);

/* What is the map's own of a ray as it goes on after a segment: flux, id, wavelength. */
void rmap_map_light_of_ray(const struct rmap_map *map, size_t space,
                           const struct rmap_portion *portion, size_t ray, size_t segment,
                           uint64_t n, struct rmap_ray_written *out);

/* All that was registered on a plane (NULL: the only one) by rays that match (NULL: all): in the
 * order of ids, positions in m. On one thread. RMAP_INPUT where there is nothing of the kind. Set
 * as rmap_scene_options.read_map. */
enum rmap_status rmap_map_light_read(const char *path, const char *detector, const char *where,
                                     struct rmap_file_rays **set_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
