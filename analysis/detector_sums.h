/* SPDX-License-Identifier: MIT
 *
 * What a detector caught, as sums that do not depend on the order of adding: of weights and
 * squared weights per source and cell (analog weights are 1, so these are exact integers in
 * double) and of colour in fixed point. One per thread and rank; merged at the end.
 */
#ifndef RMAP_DETECTOR_SUMS_H
#define RMAP_DETECTOR_SUMS_H

#include <stdbool.h>
#include <stdint.h>

#include "analysis/criterion.h"
#include "io/map_reader.h"

struct rmap_detector_sums {
    int32_t detector;
    size_t n_source, n_cell;
    size_t n_weight; /* 2 * n_source * n_cell */
    double *weight;  /* [n_source][n_cell] sums, then [n_source][n_cell] of squares; cells row by
                        row, least y first, x fastest */
    size_t n_colour; /* 3 * n_cell, or 0: no colour wanted */
    int64_t *colour; /* [n_cell][3] CIE XYZ (spectral) or linear RGB, in units of quantum */
    double quantum;  /* flux */
};

enum rmap_status rmap_detector_sums_init(struct rmap_detector_sums *sums,
                                         const struct rmap_map *map, int32_t detector, bool colour,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_detector_sums_fini(struct rmap_detector_sums *sums);

/* Adds the image that was accumulated during the trace. */
void rmap_detector_sums_add_tally(struct rmap_detector_sums *sums, const struct rmap_tally *tally);

/* Adds what the detector registered of the rays in portions [first, last) that match the
 * criterion (NULL: of all rays). */
enum rmap_status rmap_detector_sums_scan(struct rmap_detector_sums *sums,
                                         const struct rmap_map *map,
                                         const struct rmap_criterion *criterion, size_t first,
                                         size_t last, struct rmap_error *err) RMAP_MUST_USE;

/* The same detector's sums of other rays. */
void rmap_detector_sums_merge(struct rmap_detector_sums *into,
                              const struct rmap_detector_sums *from);

#endif
