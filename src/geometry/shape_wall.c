/* SPDX-License-Identifier: MIT
 *
 * Walls: straight, over an outline, from one sag to another.
 */
#include "geometry/shape_internal.h"

/* The part of the line inside of the outline's prism; where it starts on that, one end is there and
 * is dropped, the other as good as the distance between them. */
static bool through(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                    struct rmap_vec3 p, double t[2])
{
    const struct rmap_vec3 d = query->direction;
    t[0] = -HUGE_VAL;
    t[1] = HUGE_VAL;
    if ((d.x == 0 && d.y == 0) || !rmap_aperture_clip(&shape->outline, p, d, t))
        return false;
    if (query->on_surface) {
        const bool enters = rmap_dot(rmap_aperture_outward(&shape->outline, p.x, p.y), d) < 0;
        if (!shape->outline.rectangle)
            t[enters] = t[0] + t[1];
        t[!enters] = (double)NAN;
    }
    return true;
}

bool rmap_wall_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                         struct rmap_shape_hit *hit)
{
    const struct rmap_vec3 d = query->direction;
    const double shift = query->on_surface ? 0 : -rmap_dot(query->origin, d) / rmap_dot(d, d);
    const struct rmap_vec3 from = rmap_axpy(shift, d, query->origin);
    double t[2];
    if (!through(shape, query, from, t))
        return false;
    for (int k = 0; k < 2; k++) {
        struct rmap_vec3 p = rmap_axpy(t[k], d, from);
        if (!(t[k] + shift > query->t_min && t[k] + shift < query->t_max))
            continue;
        const double low = rmap_sag_height(shape->sag[0], p.x, p.y).z,
                     high = shape->length + rmap_sag_height(shape->sag[1], p.x, p.y).z;
        if (!rmap_root_belongs(query, t[k] + shift, &p, p.z >= low && p.z <= high))
            continue;
        *hit = (struct rmap_shape_hit){t[k] + shift, p,
                                       rmap_aperture_outward(&shape->outline, p.x, p.y), false};
        return true;
    }
    return false;
}
