/* SPDX-License-Identifier: MIT
 *
 * The points of a curved leg that are recorded: as few as keep their polyline within the medium's
 * `polyline` of the curve, none for a leg straight enough.
 */
#ifndef RMAP_CURVE_POINTS_H
#define RMAP_CURVE_POINTS_H

#include "gradient/curve.h"
#include "trace/recorder.h"

/* Points that wait for the next one recorded; the chord past them is near to all. */
#define RMAP_CURVE_POINTS_WAITING 32

struct rmap_curve_points {
    struct rmap_recorder *recorder; /* borrowed; NULL, or one without `curve`: nothing happens */
    double tolerance;               /* half of `polyline`: one for the steps, one for the points */
    struct rmap_vec3 from;          /* the leg's start, or the last point recorded */
    int n_waiting;
    struct rmap_curve_point waiting[RMAP_CURVE_POINTS_WAITING];
};

void rmap_curve_points_begin(struct rmap_curve_points *points, struct rmap_recorder *recorder,
                             double polyline, struct rmap_vec3 from);

/* The leg's next step, which starts after `length` and `optical_path`. The end of its last one is
 * the leg's end and not recorded. */
void rmap_curve_points_add(struct rmap_curve_points *points, const struct rmap_curve_step *step,
                           uint32_t segment, double length, double optical_path);

#endif
