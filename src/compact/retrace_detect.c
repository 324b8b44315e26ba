/* SPDX-License-Identifier: MIT
 *
 * Where a leg crosses the detector that its path names (trace/detector.c has the physics).
 */
#include "compact/detect.h"
#include "compact/portable.h"

static void on_plane(const struct rmap_detector *detector, const struct rmap_compact_leg *leg,
                     double relative[2], double *distance)
{
    struct rmap_vec3 point = leg->to;
    *distance = leg->length;
    if (!rmap_detect_lies_on(detector)) {
        double from = rmap_dot(rmap_sub(leg->from, detector->origin), detector->axis);
        double to = rmap_dot(rmap_sub(leg->to, detector->origin), detector->axis);
        *distance = leg->length * (from / (from - to));
        point = rmap_axpy(*distance, leg->direction, leg->from);
    }
    rmap_detect_point(detector, point, relative);
}

static void far_away(const struct rmap_detector *detector, const struct rmap_compact_leg *leg,
                     double relative[2])
{
    double c = rmap_dot(leg->direction, detector->axis);
    c = c > -1.0 ? c < 1.0 ? c : 1.0 : -1.0;
    double x = rmap_dot(leg->direction, detector->x), y = rmap_dot(leg->direction, detector->y);
    double phi = rmap_portable_angle(x, y < 0.0 ? -y : y);
    if (y < 0.0)
        phi = 2.0 * RMAP_PI - phi;
    relative[0] = rmap_portable_angle(c, sqrt((1.0 - c) * (1.0 + c))) / RMAP_PI;
    relative[1] = phi / (2.0 * RMAP_PI);
}

void rmap_crossing_find(const struct rmap_detector *detector, const struct rmap_compact_leg *leg,
                        struct rmap_crossing *crossing)
{
    double relative[2], distance = 0.0;
    if (detector->type == RMAP_DETECTOR_PLANE)
        on_plane(detector, leg, relative, &distance);
    else
        far_away(detector, leg, relative);
    rmap_detect_record(detector, relative, crossing->cell, crossing->relative);
    crossing->optical_path = leg->optical_from + leg->index * distance;
}
