/* SPDX-License-Identifier: MIT
 *
 * The points of a curved segment that are recorded: as few as keep their polyline within the
 * medium's `polyline` of the curve, none for a segment straight enough.
 */
#ifndef RMAP_CURVE_POINTS_H
#define RMAP_CURVE_POINTS_H

#include "gradient/curve.h"
#include "portion/recorder.h"

struct rmap_curve_points {
    struct rmap_recorder *recorder; /* borrowed; NULL: nothing happens */
    double tolerance;
    double time, bend; /* since the last point recorded: of the curve, and its greatest bend */
    bool waiting;      /* for the next one to tell whether it is needed: */
    struct rmap_curve_point point;
};

/* recorder: NULL, or one without `curve`: nothing happens. */
void rmap_curve_points_begin(struct rmap_curve_points *points, struct rmap_recorder *recorder,
                             double polyline);

/* The segment's next step, which starts after `length` and `optical_path`. The end of its last one
 * is the segment's end and not recorded. */
void rmap_curve_points_add(struct rmap_curve_points *points, const struct rmap_curve_step *step,
                           uint32_t segment, double length, double optical_path);

#endif
