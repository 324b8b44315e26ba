/* SPDX-License-Identifier: MIT
 *
 * Irradiance or illuminance on the cells of objects, with standard errors: flux that arrives in a
 * cell over its area, and the part of it that is absorbed there.
 */
#ifndef RMAP_IRRADIANCE_IMAGE_H
#define RMAP_IRRADIANCE_IMAGE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/image_unit.h"
#include "analysis/detector/irradiance_sums.h"
#include "analysis/detector/uniformity.h"

/* Of an object, or of all. */
struct rmap_irradiance_object {
    double area_m2;
    double flux[RMAP_IRRADIANCE_PARTS], flux_error[RMAP_IRRADIANCE_PARTS];
    double mean, mean_error;
    size_t least, greatest; /* cells */
};

struct rmap_irradiance_image {
    const struct rmap_irradiance_cells *cells; /* borrowed */
    const char *criterion;                     /* borrowed; NULL: all rays */
    enum rmap_side side;
    const char *quantity, *unit, *flux_unit; /* "illuminance", "lx", "lm" */
    double *value[RMAP_IRRADIANCE_PARTS];    /* [n_cell] of each */
    double *standard_error[RMAP_IRRADIANCE_PARTS];
    double *relative_error;                /* [n_cell] of what arrives; NaN: nothing does */
    struct rmap_irradiance_object *object; /* [n_part], then of all */
    struct rmap_uniformity uniformity;     /* of the cells, each counting once */
    size_t n_empty;                        /* cells without light */
    double usual_error; /* median of the relative errors of the others; NaN: none is known */
};

/* unit: NULL: the usual one. RMAP_USAGE where it does not fit. */
enum rmap_status rmap_irradiance_image_create(const struct rmap_irradiance_sums *sums,
                                              const char *unit,
                                              struct rmap_irradiance_image **image_ret,
                                              struct rmap_error *err) RMAP_MUST_USE;
void rmap_irradiance_image_destroy(struct rmap_irradiance_image *image); /* NULL is fine */

/* Lines of "# key: value", then a row for every cell. */
void rmap_irradiance_image_csv(const struct rmap_irradiance_image *image, FILE *out);

/* For people, and as a JSON object (new reference; NULL when memory is short). */
enum rmap_status rmap_irradiance_image_print(const struct rmap_irradiance_image *image, FILE *out,
                                             struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_irradiance_image_json(const struct rmap_irradiance_image *image);

#endif
