/* SPDX-License-Identifier: MIT
 *
 * Virtual detectors, which watch and never disturb the light. A ray CROSSES a detector when it
 * meets its area, and is REGISTERED when its side and angle limits accept it too.
 */
#ifndef RMAP_DETECTOR_H
#define RMAP_DETECTOR_H

#include "gradient/curve.h"
#include "portion/recorder.h"
#include "scene/scene.h"

/* What arrival times of light on its way are made of, in a scene with `timed`; else 0. */
struct rmap_clock {
    double group_path;  /* from emission to the start of the segment, or of the piece of a curve */
    double group_index; /* along the segment; 0 once it has been travelled */
    double delay_ns;
};

/* A straight segment. `to` must be the very point at which the next segment starts: a plane is
 * crossed when `from` lies on one side of it and `to` on it or on the other, so that no crossing is
 * missed or counted twice by rounding. */
struct rmap_segment {
    struct rmap_vec3 from, to;
    struct rmap_vec3 direction; /* unit */
    double length;
    double optical_from, index;     /* optical path at `from`; refractive index along the segment */
    uint32_t segment;               /* its number within the ray, from 0 */
    const struct rmap_clock *clock; /* borrowed; NULL: none */
};

/* Planes free in space that the segment crosses, by distance, then by detector index. */
void rmap_detect_free(const struct rmap_scene *scene, const struct rmap_segment *segment,
                      struct rmap_recorder *recorder);

/* A step of a curved segment, from theta 0 to 1. from, to: the very points at which its neighbours
 * end and start, as above. */
struct rmap_segment_piece {
    const struct rmap_curve_step *step;
    struct rmap_vec3 from, to;
    double optical_from; /* optical path at `from` */
    double tolerance;    /* a curve that dips through a plane by less may go unnoticed */
    uint32_t segment;
    const struct rmap_clock *clock;       /* borrowed; NULL: none. group_path: at `from` */
    const struct rmap_gradient *gradient; /* with a clock: borrowed, */
    int channel;                          /* of the light */
};

/* Planes free in space that the curve crosses, each as often as it does, along the curve. */
void rmap_detect_curve(const struct rmap_scene *scene, const struct rmap_segment_piece *piece,
                       struct rmap_recorder *recorder);

/* Planes lying on the object met at the end of the segment, or on the face that this primitive of
 * it is of: the point is projected along the detector's axis onto its plane. */
void rmap_detect_on(const struct rmap_scene *scene, const struct rmap_segment *segment,
                    int32_t object, int32_t primitive, struct rmap_recorder *recorder);

/* Intensity grids, for a segment that leaves the scene. optical_path: without that segment. */
void rmap_detect_far(const struct rmap_scene *scene, const struct rmap_segment *segment,
                     struct rmap_recorder *recorder);

#endif
