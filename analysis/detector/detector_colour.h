/* SPDX-License-Identifier: MIT
 *
 * What light a detector caught, as colour: CIE XYZ, chromaticity, colour temperature, Duv and
 * colour rendering, of all of it and of each cell.
 */
#ifndef RMAP_DETECTOR_COLOUR_H
#define RMAP_DETECTOR_COLOUR_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/detector_sums.h"
#include "optics/chromaticity.h"
#include "optics/colour_rendering.h"

/* Where there is no light, or no error is known, numbers are NaN. */
struct rmap_colour_reading {
    double xyz[3], xyz_error[3];           /* in the unit of the colour */
    struct rmap_chromaticity value, error; /* standard errors */
    double general;                        /* Ra */
};

enum { RMAP_COLOUR_UNIT = 16 };
struct rmap_detector_colour {
    char unit[RMAP_COLOUR_UNIT]; /* "lx": Y is the illuminance */
    size_t n_cell;
    struct rmap_colour_reading all, *cell; /* [n_cell] */
    struct rmap_cri cri;                   /* of all, unless there is a reason */
    const char *no_cct, *no_cri;           /* reasons, or NULL */
    bool cri_of_cells;
};

/* Of sums taken with `xyz`; Ra of cells where they have `channels`, too. */
enum rmap_status rmap_detector_colour_create(const struct rmap_detector_sums *sums,
                                             struct rmap_detector_colour **colour_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_detector_colour_destroy(struct rmap_detector_colour *colour);

void rmap_detector_colour_print(const struct rmap_detector_colour *colour, FILE *out);
json_t *rmap_detector_colour_json(const struct rmap_detector_colour *colour);

/* The names of a cell's numbers, and those: X to Z, their errors, x, y, u', v', CCT, Duv, Ra. */
enum { RMAP_COLOUR_NUMBERS = 13 };
extern const char *const rmap_colour_number[RMAP_COLOUR_NUMBERS];
double rmap_colour_number_of(const struct rmap_colour_reading *reading, int number);

#endif
