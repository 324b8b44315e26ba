/* SPDX-License-Identifier: MIT
 *
 * A spot: where the light on a plane has its centre, how large it is, which part of it lies within
 * a radius, and which contrast it leaves to lines (MTF), each with the standard error that the
 * number of rays gives it.
 *
 * The MTF is the modulus of the transform of the stored positions themselves, no pixels between:
 * geometric, without diffraction. Tangential: frequencies along the line from the detector's centre
 * to the spot (y where the spot lies on it), sagittal: across. Errors by the delta method
 * (docs/detectors.md); those of radii leave out that the centre is estimated, too.
 */
#ifndef RMAP_SPOT_H
#define RMAP_SPOT_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/spot_sums.h"

struct rmap_estimate {
    double value, standard_error; /* NaN: not defined */
};

#define RMAP_SPOT_FRACTIONS 3 /* 50, 80, 90 % */
#define RMAP_SPOT_CURVE     101

struct rmap_spot {
    const char *unit;               /* of length */
    const struct rmap_which *which; /* registrations that were counted, borrowed; NULL: all */
    struct rmap_estimate flux;
    struct rmap_estimate centroid[2], rms[2], rms_radius;
    double fraction[RMAP_SPOT_FRACTIONS];
    struct rmap_estimate radius[RMAP_SPOT_FRACTIONS];
    double curve_radius[RMAP_SPOT_CURVE];
    struct rmap_estimate curve[RMAP_SPOT_CURVE]; /* encircled energy at these radii, of 1 */
    double tangential_deg;
    size_t n_frequency;
    double frequency_step;        /* cycles per unit of length */
    struct rmap_estimate *mtf;    /* [2][n_frequency], tangential first */
    struct rmap_estimate half[2]; /* the lowest frequency with a contrast of one half; NaN: none */
};

/* NaN everywhere where no light was registered. */
enum rmap_status rmap_spot_create(const struct rmap_spot_sums *sums, struct rmap_spot **spot_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_spot_destroy(struct rmap_spot *spot); /* NULL is fine */

void rmap_spot_print(const struct rmap_spot *spot, FILE *out);

/* Adds "spot" and, if there is one, "mtf" to a document. */
void rmap_spot_json(const struct rmap_spot *spot, json_t *document);

/* curve,at,value,standard_error: rows of encircled, tangential and sagittal. */
void rmap_spot_csv(const struct rmap_spot *spot, const char *detector, const char *criterion,
                   FILE *out);

#endif
