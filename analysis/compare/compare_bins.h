/* SPDX-License-Identifier: MIT
 *
 * What differs where: a comparison bin by bin, over the cells of a detector or the values of a
 * number. Each bin is the difference of two fluxes, as the scalars of the comparison are
 * (difference.h): its error is that under the hypothesis that both samples are the same.
 */
#ifndef RMAP_COMPARE_BINS_H
#define RMAP_COMPARE_BINS_H

#include "analysis/compare/compare.h"
#include "analysis/compare/compare_field.h"
#include "analysis/detector/detector_sums.h"
#include "io/export/svg.h"

struct rmap_compare_bins {
    char *name;                          /* "sensor", "path_length"; owned */
    bool is_image;                       /* of a detector's cells; else of a number's values */
    struct rmap_detector_bins grid;      /* of an image: that of the first map */
    size_t n[2];                         /* u fastest; n[1] is 1 for a number */
    double *edge;                        /* of a number: [n[0] + 1] */
    const char *axis_unit;               /* of u and v, or of the number; "" of a plain number */
    const char *quantity, *unit;         /* of what follows: "irradiance", "W/m2"; "flux", "W" */
    double *memory;                      /* all of them, [n[0] n[1]] each */
    double *value[2], *error[2];         /* of each sample by itself */
    double *difference, *standard_error; /* value[0] - value[1] */
    double *z;                           /* NaN where it cannot be said */
    double *place[2];                    /* of an image: the middle of each cell, in axis_unit */
};

/* sums: as those of rmap_comparison_add_sums, of one detector; the third NULL where two maps are
 * compared. RMAP_INPUT where the detector's grids differ. */
enum rmap_status rmap_compare_bins_of_images(const struct rmap_comparison *comparison,
                                             const struct rmap_detector_sums *const sums[3],
                                             struct rmap_compare_bins **bins_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* fields: as those of rmap_comparison_add_field, of a number; fine bins are joined to some 50. */
enum rmap_status rmap_compare_bins_of_field(const struct rmap_comparison *comparison,
                                            const char *name,
                                            const struct rmap_compare_field *const fields[3],
                                            struct rmap_compare_bins **bins_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;
void rmap_compare_bins_destroy(struct rmap_compare_bins *bins); /* NULL is fine */

/* "x" and "y", or "theta" and "phi", of an image. */
const char *rmap_compare_bins_axis(const struct rmap_compare_bins *bins, int k);

/* {"name", "cells" and "x", "y", or "edges"; "a", "b", "difference", "z" ...} */
json_t *rmap_compare_bins_json(const struct rmap_compare_bins *bins); /* NULL: no memory */

/* Lines of "# key: value", then a line per bin. */
void rmap_compare_bins_csv(const struct rmap_comparison *comparison,
                           const struct rmap_compare_bins *bins, FILE *out);

#endif
