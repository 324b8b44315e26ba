/* SPDX-License-Identifier: MIT
 *
 * Where a leg crosses the detector that its path names (trace/detector.c has the physics).
 */
#include "compact/model.h"
#include "compact/portable.h"

static uint16_t cell_of(double relative, uint32_t cells)
{
    double cell = relative * (double)cells;
    if (!(cell > 0.0))
        return 0;
    return cell < (double)cells ? (uint16_t)(uint32_t)cell : (uint16_t)(cells - 1);
}

static uint16_t quantise(double x)
{
    double bounded = x > 0.0 ? x < 1.0 ? x : 1.0 : 0.0; /* NaN: 0 */
    return (uint16_t)(65535.0 * bounded + 0.5);
}

static void on_plane(const struct rmap_detector *detector, const struct rmap_compact_leg *leg,
                     double relative[2], double *distance)
{
    struct rmap_vec3 point = leg->to;
    *distance = leg->length;
    if (detector->on_object < 0 && detector->on_group < 0) {
        double from = rmap_dot(rmap_sub(leg->from, detector->origin), detector->axis);
        double to = rmap_dot(rmap_sub(leg->to, detector->origin), detector->axis);
        *distance = leg->length * (from / (from - to));
        point = rmap_axpy(*distance, leg->direction, leg->from);
    }
    struct rmap_vec3 offset = rmap_sub(point, detector->origin);
    relative[0] = rmap_dot(offset, detector->x) / detector->size[0] + 0.5;
    relative[1] = rmap_dot(offset, detector->y) / detector->size[1] + 0.5;
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
    for (int k = 0; k < 2; k++) {
        crossing->cell[k] = cell_of(relative[k], detector->cells[k]);
        crossing->relative[k] = quantise(relative[k]);
    }
    crossing->optical_path = leg->optical_from + leg->index * distance;
}
