/* SPDX-License-Identifier: MIT
 *
 * Walls: straight, over an outline, from one sag to another.
 */
#include "geometry/shape_internal.h"

struct rmap_vec3 rmap_wall_normal(const struct rmap_shape *shape, struct rmap_vec3 point)
{
    return shape->outline.rectangle ? rmap_side_outward(shape->side)
                                    : rmap_aperture_outward(&shape->outline, point.x, point.y);
}

/* The plane of a side. */
static int meet_side(const struct rmap_shape *shape, bool on_surface, struct rmap_vec3 p,
                     struct rmap_vec3 d, double t[2])
{
    const struct rmap_aperture *a = &shape->outline;
    const struct rmap_vec3 n = rmap_side_outward(shape->side);
    const double rate = rmap_dot(n, d);
    if (on_surface || rate == 0)
        return 0;
    const int k = shape->side % 2;
    t[0] = (a->half[k] - rmap_dot(n, rmap_vec3(p.x - a->at[0], p.y - a->at[1], 0))) / rate;
    return 1;
}

/* Where it enters and leaves the ellipse's cylinder; of a line that starts on that, the other end,
 * as good as the distance between them. */
static int meet_round(const struct rmap_shape *shape, bool on_surface, struct rmap_vec3 p,
                      struct rmap_vec3 d, double t[2])
{
    t[0] = -HUGE_VAL;
    t[1] = HUGE_VAL;
    if ((d.x == 0 && d.y == 0) || !rmap_aperture_clip(&shape->outline, p, d, t))
        return 0;
    if (!on_surface)
        return 2;
    t[0] += t[1];
    return 1;
}

int rmap_wall_roots(const struct rmap_shape *shape, bool on_surface, struct rmap_vec3 p,
                    struct rmap_vec3 d, double t[2])
{
    return (shape->outline.rectangle ? meet_side : meet_round)(shape, on_surface, p, d, t);
}

static bool belongs(const struct rmap_shape *shape, struct rmap_vec3 p)
{
    const struct rmap_aperture *a = &shape->outline;
    const int k = 1 - shape->side % 2;
    const double low = rmap_sag_height(shape->sag[0], p.x, p.y).z,
                 high = shape->length + rmap_sag_height(shape->sag[1], p.x, p.y).z;
    return p.z >= low && p.z <= high &&
           (!a->rectangle || fabs((k ? p.y : p.x) - a->at[k]) <= a->half[k]);
}

bool rmap_wall_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                         struct rmap_shape_hit *hit)
{
    const struct rmap_vec3 d = query->direction;
    const double shift = query->on_surface ? 0 : -rmap_dot(query->origin, d) / rmap_dot(d, d);
    const struct rmap_vec3 from = rmap_axpy(shift, d, query->origin);
    double t[2];
    const int n = rmap_wall_roots(shape, query->on_surface, from, d, t);
    for (int k = 0; k < n; k++) {
        struct rmap_vec3 p = rmap_axpy(t[k], d, from);
        if (!(t[k] + shift > query->t_min && t[k] + shift < query->t_max) ||
            !rmap_root_belongs(query, t[k] + shift, &p, belongs(shape, p)))
            continue;
        *hit = (struct rmap_shape_hit){t[k] + shift, p, rmap_wall_normal(shape, p), false};
        return true;
    }
    return false;
}
