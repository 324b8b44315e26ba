/* SPDX-License-Identifier: MIT
 *
 * Of many rays those that a section shows as they ran: all their way near its plane.
 */
#include "analysis/figure/near_plane.h"

#include "portion/event.h"

/* Whether n points, three numbers each, lie so near. */
static bool are_near(const struct rmap_view *view, double distance, const float *point, size_t n)
{
    for (size_t i = 0; i < n; i++, point += 3) {
        const struct rmap_vec3 at = rmap_vec3((double)point[0], (double)point[1], (double)point[2]);
        if (!(fabs(rmap_view_place(view, at).z) <= distance))
            return false;
    }
    return true;
}

static bool is_near(const struct rmap_view *view, double distance, const struct rmap_portion *rays,
                    size_t ray, size_t segment)
{
    size_t n = rays->ray.segment_count[ray], curve;
    const size_t n_curve = rmap_portion_curve_of(rays, rays->ray.id[ray], &curve);
    if (n > 0 && rays->segment.event[segment + n - 1] & RMAP_EVENT_LEFT)
        n--; /* that one has no end */
    return are_near(view, distance, rays->ray.start + 3 * ray, 1) &&
           are_near(view, distance, rays->segment.position + 3 * segment, n) &&
           are_near(view, distance, rays->curve.position + 3 * curve, n_curve);
}

enum rmap_status rmap_near_plane_keep(const struct rmap_view *view, struct rmap_near_plane *near,
                                      struct rmap_portion **rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *all = *rays;
    struct rmap_portion *kept = NULL;
    RMAP_TRY(rmap_portion_create(1, all->n_channel, &kept, err));
    near->looked = all->n_row[RMAP_TABLE_RAY];
    near->near = 0;
    for (size_t i = 0, segment = 0, registration = 0; i < near->looked; i++) {
        if (is_near(view, near->distance, all, i, segment) && near->near++ < near->most)
            RMAP_TRY(rmap_portion_append_ray(kept, all, i, segment, registration, err));
        segment += all->ray.segment_count[i];
        registration += all->ray.registration_count[i];
    }
    rmap_portion_destroy(*rays);
    *rays = kept;
    kept = NULL;
out:
    rmap_portion_destroy(kept);
    return st;
}
