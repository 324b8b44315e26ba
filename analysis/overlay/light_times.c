/* SPDX-License-Identifier: MIT
 *
 * When the light of a timed run was where.
 */
#include "analysis/overlay/light_times.h"

#include <inttypes.h>

#include "analysis/overlay/overlay_segment.h"
#include "base/alloc.h"

/* Times of one ray's segments. */
static enum rmap_status add_ray(struct rmap_light_times *times, struct rmap_overlay_ray *ray,
                                struct rmap_error *err)
{
    const struct rmap_portion *rays = ray->portion;
    const double unit = ray->scene->unit_m / 0.299792458; /* ns per length */
    struct rmap_vec3 from = rmap_vec3_of(rays->ray.start + 3 * ray->row);
    double optical = 0.0, delay;
    ray->clock = (struct rmap_clock){0};
    for (uint32_t k = 0; k < ray->n_segment; k++)
        if ((size_t)rays->segment.medium[ray->segment + k] >= ray->scene->n_medium)
            return rmap_error_set(err, RMAP_FORMAT,
                                  "damaged map: segment %u of ray %" PRIu64
                                  " has a medium that the scene has not",
                                  k, rays->ray.id[ray->row]);
    delay = rmap_overlay_emission_delay(ray);
    times->leaving[ray->row] = unit;
    for (uint32_t k = 0; k < ray->n_segment; k++) {
        struct rmap_segment segment;
        const size_t row = ray->segment + k;
        const uint32_t event = rays->segment.event[row];
        times->begin[row] = delay + unit * ray->clock.group_path;
        rmap_overlay_segment(ray->scene, ray, k, from, optical, &segment);
        if (event & RMAP_EVENT_GRADIENT)
            rmap_overlay_curve(NULL, ray, &segment, NULL);
        else if (event & RMAP_EVENT_LEFT)
            times->leaving[ray->row] = unit * ray->clock.group_index;
        else
            ray->clock.group_path += ray->clock.group_index * segment.length;
        times->end[row] = delay + unit * ray->clock.group_path;
        delay += rmap_overlay_delay(ray, k);
        from = segment.to;
    }
    return RMAP_OK;
}

static enum rmap_status add_rays(const struct rmap_map *map, const struct rmap_portion *rays,
                                 struct rmap_light_times *times, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_overlay_ray ray = {.portion = rays};
    for (; ray.row < rays->n_row[RMAP_TABLE_RAY]; ray.row++, ray.segment += ray.n_segment) {
        const uint64_t id = rays->ray.id[ray.row];
        ray.scene = rmap_map_scene_of(map, rmap_map_space_of_ray(map, id));
        ray.n_segment = rays->ray.segment_count[ray.row];
        if (ray.n_segment > rays->n_row[RMAP_TABLE_SEGMENT] - ray.segment)
            return rmap_error_set(err, RMAP_FORMAT, "damaged map: rows do not fit together");
        const size_t n_point = rmap_portion_curve_of(rays, id, &ray.curve);
        ray.curve_end = ray.curve + n_point;
        RMAP_TRY(add_ray(times, &ray, err));
    }
out:
    return st;
}

enum rmap_status rmap_light_times_check(const struct rmap_map *map, struct rmap_error *err)
{
    if (rmap_map_scene(map)->timed)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "this map has no arrival times: trace its scene with 'time: on' in the "
                          "simulation, or raymap trace --time on");
}

enum rmap_status rmap_light_times_create(const struct rmap_map *map,
                                         const struct rmap_portion *rays,
                                         struct rmap_light_times **times_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = rays->n_row[RMAP_TABLE_RAY], n_segment = rays->n_row[RMAP_TABLE_SEGMENT];
    struct rmap_light_times *times = NULL;
    times = rmap_alloc(1, sizeof *times);
    if (times) {
        times->begin = rmap_alloc(n_segment + 1, sizeof *times->begin);
        times->leaving = rmap_alloc(n_ray + 1, sizeof *times->leaving);
        times->end = rmap_alloc(n_segment + 1, sizeof *times->end);
    }
    if (!times || !times->begin || !times->leaving || !times->end)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the times of %zu rays", n_ray);
    if (st == RMAP_OK)
        st = add_rays(map, rays, times, err);
    if (st == RMAP_OK)
        *times_ret = times;
    else
        rmap_light_times_destroy(times);
    return st;
}

void rmap_light_times_destroy(struct rmap_light_times *times)
{
    if (!times)
        return;
    rmap_free(times->begin);
    rmap_free(times->leaving);
    rmap_free(times->end);
    rmap_free(times);
}
