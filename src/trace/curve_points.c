/* SPDX-License-Identifier: MIT */
#include "trace/curve_points.h"

#include <math.h>
#include <stddef.h>

/* Of one step. */
#define PARTS_MAX 4096

void rmap_curve_points_begin(struct rmap_curve_points *points, struct rmap_recorder *recorder,
                             double polyline, struct rmap_vec3 from)
{
    points->recorder = recorder && recorder->curve ? recorder : NULL;
    points->tolerance = 0.5 * polyline;
    points->from = from;
    points->n_waiting = 0;
}

/* Do the points that wait lie near the line to `to`? */
static bool is_straight(const struct rmap_curve_points *points, struct rmap_vec3 to)
{
    struct rmap_vec3 way = rmap_sub(to, points->from);
    double square = rmap_dot(way, way), most = points->tolerance * points->tolerance;
    for (int i = 0; i < points->n_waiting; i++) {
        struct rmap_vec3 p = rmap_sub(points->waiting[i].position, points->from);
        double share = square > 0.0 ? rmap_dot(p, way) / square : 0.0;
        struct rmap_vec3 off = rmap_axpy(-fmax(0.0, fmin(share, 1.0)), way, p);
        if (rmap_dot(off, off) > most)
            return false;
    }
    return true;
}

static void push(struct rmap_curve_points *points, const struct rmap_curve_point *point)
{
    if (points->n_waiting == RMAP_CURVE_POINTS_WAITING || !is_straight(points, point->position)) {
        const struct rmap_curve_point *last = &points->waiting[points->n_waiting - 1];
        points->recorder->curve(points->recorder, last);
        points->from = last->position;
        points->n_waiting = 0;
    }
    points->waiting[points->n_waiting++] = *point;
}

void rmap_curve_points_add(struct rmap_curve_points *points, const struct rmap_curve_step *step,
                           uint32_t segment, double length, double optical_path)
{
    if (!points->recorder)
        return;
    double parts = ceil(sqrt(rmap_curve_sag(step, 0.0, 1.0) / points->tolerance));
    int n = (int)fmax(1.0, fmin(parts, PARTS_MAX));
    for (int i = 1; i <= n; i++) {
        struct rmap_curve_point point = {.segment = segment};
        double theta = (double)i / n, so_far, optical;
        struct rmap_vec3 T;
        rmap_curve_at(step, theta, &point.position, &T);
        rmap_curve_lengths(step, theta, &optical, &so_far);
        point.index = rmap_length(T);
        point.direction = rmap_scale(T, 1.0 / point.index);
        point.length = length + so_far;
        point.optical_path = optical_path + optical;
        push(points, &point);
    }
}
