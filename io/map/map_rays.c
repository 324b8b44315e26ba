/* SPDX-License-Identifier: MIT
 *
 * Which rays a map holds, and which it was asked for.
 */
#include "io/map/map_rays.h"

#include "base/alloc.h"
#include "io/map/map_internal.h"
#include "io/map/selection.h"

struct rmap_ray_range rmap_run_rays(const struct rmap_run_row *run)
{
    const uint64_t first = run->first_ray, room = RMAP_RAY_END - first;
    return (struct rmap_ray_range){first, first + (run->n_ray < room ? run->n_ray : room)};
}

enum rmap_status rmap_rays_held(const struct rmap_map_content *content, struct rmap_ray_set *set,
                                struct rmap_error *err)
{
    struct rmap_ray_range *range = rmap_alloc(content->n_portion, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of rays");
    for (size_t i = 0; i < content->n_portion; i++) {
        const struct rmap_portion_info *info = &content->portion[i];
        range[i] = (struct rmap_ray_range){info->first_ray, rmap_portion_end(info)};
    }
    enum rmap_status st = rmap_ray_set_make(range, content->n_portion, set, err);
    rmap_free(range);
    return st;
}

enum rmap_status rmap_rays_wanted(const struct rmap_map *map, struct rmap_ray_set *set,
                                  struct rmap_error *err)
{
    const size_t n = rmap_map_n_run(map);
    struct rmap_ray_range *range = rmap_alloc(n, sizeof *range);
    if (!range)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of runs");
    for (size_t i = 0; i < n; i++)
        range[i] = rmap_run_rays(rmap_map_run(map, i));
    enum rmap_status st = rmap_ray_set_make(range, n, set, err);
    rmap_free(range);
    return st;
}

bool rmap_rays_asked(const struct rmap_map *map, uint64_t *n_ret)
{
    *n_ret = map->n_asked;
    return !map->selection && map->n_run > 0 && map->n_asked <= INT64_MAX;
}

bool rmap_map_is_whole(const struct rmap_map *map)
{
    const struct rmap_selection *picked = rmap_map_selection(map);
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    return summary.complete && (!picked || picked->complete);
}
