/* SPDX-License-Identifier: MIT
 *
 * The points of a curved segment that are recorded: as few as keep their polyline within the
 * medium's `polyline` of the curve, none for a segment straight enough.
 */
#include "portion/curve_points.h"

#include <math.h>
#include <stddef.h>

/* Of one step. */
#define PARTS_MAX 4096

void rmap_curve_points_begin(struct rmap_curve_points *points, struct rmap_recorder *recorder,
                             double polyline)
{
    points->recorder = recorder && recorder->curve ? recorder : NULL;
    points->tolerance = polyline;
    points->time = points->bend = 0.0;
    points->waiting = false;
}

/* A point of the curve, `dt` after the one before: that one is recorded where a chord past it
 * would leave the curve too far. */
static void push(struct rmap_curve_points *points, const struct rmap_curve_point *point, double dt,
                 double bend)
{
    double time = points->time + dt, most = fmax(points->bend, bend);
    if (points->waiting && 0.125 * most * time * time > points->tolerance) {
        points->recorder->curve(points->recorder, &points->point);
        time = dt;
        most = bend;
    }
    points->time = time;
    points->bend = most;
    points->point = *point;
    points->waiting = true;
}

void rmap_curve_points_add(struct rmap_curve_points *points, const struct rmap_curve_step *step,
                           uint32_t segment, double length, double optical_path)
{
    if (!points->recorder)
        return;
    double bend = rmap_curve_bend(step);
    double parts = ceil(step->h * sqrt(0.125 * bend / points->tolerance));
    int n = (int)fmax(1.0, fmin(parts, PARTS_MAX));
    for (int i = 1; i <= n; i++) {
        struct rmap_curve_point point = {.segment = segment, .position = step->to.r};
        double theta = (double)i / n, so_far = step->length, optical = step->optical;
        struct rmap_vec3 T = step->to.T;
        if (i < n) {
            rmap_curve_at(step, theta, &point.position, &T);
            rmap_curve_lengths(step, theta, &optical, &so_far);
        }
        point.index = rmap_length(T);
        point.direction = rmap_scale(T, 1.0 / point.index);
        point.length = length + so_far;
        point.optical_path = optical_path + optical;
        push(points, &point, step->h / n, bend);
    }
}
