/* SPDX-License-Identifier: MIT
 *
 * Sums over the places where rays were registered on a plane, about a given centre: what centroid,
 * spot size, encircled energy and MTF are made of. Same bits in any order: exact sums of the
 * moments, whole numbers per ring, fixed point for the transform.
 */
#ifndef RMAP_SPOT_SUMS_H
#define RMAP_SPOT_SUMS_H

#include "analysis/detector/detector_bins.h"
#include "analysis/query/fold.h"
#include "base/exact_sum.h"

/* All borrowed. */
struct rmap_spot_ask {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;
    int32_t detector;               /* a plane, in rmap_scene_with(map, overlay) */
    struct rmap_detector_bins bins; /* whose region counts */
    double centre[2];               /* x and y on the detector, near the centroid */
    size_t n_frequency;             /* from 0; 0: no transform */
    double frequency_step;          /* cycles per unit of length */
    double tangential_rad;          /* direction of tangential frequencies, from x towards y */
    bool moments_alone;             /* no rings: radii within which light lies are not defined */
};

/* What a ray adds in all: weight, weight times x, y, x x, y y, from the centre. */
#define RMAP_SPOT_VECTOR 5
#define RMAP_SPOT_GRAM   (RMAP_SPOT_VECTOR * (RMAP_SPOT_VECTOR + 1) / 2)

/* Rings: bin 0 holds the centre itself, each octave of the radius RMAP_SPOT_PER_OCTAVE rings. */
#define RMAP_SPOT_OCTAVES    48
#define RMAP_SPOT_PER_OCTAVE 2048
#define RMAP_SPOT_RINGS      (RMAP_SPOT_OCTAVES * RMAP_SPOT_PER_OCTAVE + 1)

/* Of a frequency: sums of c, s, cc, cs, ss, qc, qs, with q the ray's weight in all and c, s the
 * weighted cosines and sines of its phases. */
#define RMAP_SPOT_WAVES 7

/* Counts of the fixed point in one. */
#define RMAP_SPOT_FIXED 4294967296.0

struct rmap_spot_point;

struct rmap_spot_sums {
    struct rmap_spot_ask ask;
    size_t n_source, n_ring;    /* n_ring: of all numbers of `ring` */
    double radius_max;          /* upper edge of the last ring */
    struct rmap_exact_sum *sum; /* [n_source][RMAP_SPOT_VECTOR + RMAP_SPOT_GRAM]: v, then v v^T,
                                   row by row from the diagonal on */
    double *ring;               /* [n_source][3][RMAP_SPOT_RINGS]: what the ring adds, coming from
                                   within, to sums of w, of w^2 per ray, of w times the ray's all */
    int64_t *wave;              /* [n_source][2][n_frequency][RMAP_SPOT_WAVES], tangential first */
    struct rmap_spot_point *point; /* of the ray in hand */
    size_t cap_point;
    double (*phase)[2]; /* [2 n_frequency] of the ray in hand */
};

/* Radius at which ring `ring` ends. */
double rmap_spot_ring_end(const struct rmap_spot_sums *sums, size_t ring);

/* As a fold (fold.h): context a struct rmap_spot_ask, states struct rmap_spot_sums. RMAP_USAGE
 * when there are so many sources that a state would take more than 1 GB. */
extern const struct rmap_fold_kind rmap_spot_sums_kind;
rmap_column_set rmap_spot_sums_columns(const struct rmap_spot_ask *ask);

#endif
