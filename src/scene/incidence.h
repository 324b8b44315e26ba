/* SPDX-License-Identifier: MIT
 *
 * The direction in which light reaches a detector, against the detector's axis.
 */
#ifndef RMAP_INCIDENCE_H
#define RMAP_INCIDENCE_H

#include "scene/scene.h"

/* A direction against an axis: its parts across and along it, >= 0 and any. */
struct rmap_tilt {
    double across, along;
};

/* As the tracer counts it: of the reversed ray, or, on an intensity grid, of the ray itself.
 * direction: [3]. */
static inline struct rmap_tilt rmap_incidence(const struct rmap_detector *detector,
                                              const float *direction)
{
    const double sign = detector->type == RMAP_DETECTOR_INTENSITY ? 1.0 : -1.0;
    const struct rmap_vec3 d = rmap_vec3(sign * (double)direction[0], sign * (double)direction[1],
                                         sign * (double)direction[2]);
    return (struct rmap_tilt){rmap_length(rmap_cross(d, detector->axis)),
                              rmap_dot(d, detector->axis)};
}

#endif
