/* SPDX-License-Identifier: MIT
 *
 * What the parts of the overlay (overlay*.c) share.
 */
#ifndef RMAP_OVERLAY_SEGMENT_H
#define RMAP_OVERLAY_SEGMENT_H

#include "analysis/overlay/overlay.h"
#include "trace/detector.h"

struct rmap_overlay {
    const struct rmap_map *map;
    struct rmap_scene *read;        /* owns the receivers' names and the lists of detectors */
    struct rmap_scene scene;        /* the map's, with `read`'s detectors and sphere */
    struct rmap_scene alone;        /* the same with the receivers' lists alone */
    struct rmap_detector *detector; /* [scene.n_detector] */
    size_t first;
    bool lies_on;          /* any receiver lies on an object, */
    bool on_faces;         /* on some faces of one */
    bool needs_index;      /* any medium is dispersive: optical paths need colours */
    bool needs_wavelength; /* any gradient medium is: curves need colours */
};

/* A ray of a stored portion: its rows in the other tables. */
struct rmap_overlay_ray {
    const struct rmap_portion *portion;
    const struct rmap_scene *scene; /* of its colour space */
    size_t row, segment, n_segment, registration, n_registration;
    size_t curve, curve_end; /* rows of /curve not yet passed */
    struct rmap_clock clock;
};

/* Segment `segment` of the ray, as light that detectors watch. false: it has no length. from: where
 * the segment before ended; optical: the path up to there. The straight segment's `to` is where it
 * ends, or for one that left, on the bounding sphere of the scene `within`. */
void rmap_overlay_segment(const struct rmap_scene *within, struct rmap_overlay_ray *ray,
                          uint32_t segment, struct rmap_vec3 from, double optical,
                          struct rmap_segment *out);

/* Delay of the fluorescence at the end of the segment, ns, drawn again: 0 for other events. And
 * that of the emission: the rest of the ray's. */
double rmap_overlay_delay(const struct rmap_overlay_ray *ray, uint32_t segment);
double rmap_overlay_emission_delay(const struct rmap_overlay_ray *ray);

/* Lets the free planes of `scene` (NULL: none) watch the curved segment; `out`: as
 * rmap_overlay_segment left it, gets the direction at its end, and its optical path there as
 * `optical_from` with index 0. */
void rmap_overlay_curve(const struct rmap_scene *scene, struct rmap_overlay_ray *ray,
                        struct rmap_segment *out, struct rmap_recorder *recorder);

#endif
