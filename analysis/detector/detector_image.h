/* SPDX-License-Identifier: MIT
 *
 * A detector's image in physical units, and what people ask of it: total, mean, peak, errors.
 *
 * Flux per area (W/m2, lx), per solid angle (W/sr, cd), per both and cosine (W/(m2 sr), cd/m2), or
 * per cell. Standard errors are those of the flux estimate (docs/physics.md), a ray being one
 * sample wherever it was registered; NaN where a source has fewer than 2 rays.
 */
#ifndef RMAP_DETECTOR_IMAGE_H
#define RMAP_DETECTOR_IMAGE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/detector_sums.h"
#include "analysis/detector/uniformity.h"
#include "io/map/map_cut.h"

struct rmap_detector_share {
    double registrations, flux, flux_error;
};

struct rmap_detector_image {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_detector *detector;
    const struct rmap_which *which;   /* registrations that were counted, borrowed; NULL: all */
    const struct rmap_map_part *part; /* what of the map was asked, borrowed; NULL: all of it */
    struct rmap_detector_bins bins;
    bool world; /* places are told in the world; of planes alone */
    uint32_t n[2];
    double *value;          /* [n[1]][n[0]], least y first */
    double *standard_error; /* same layout */
    double *rays;           /* registrations (sum of weights), same layout */
    double *rgb;            /* [n[1]][n[0]][3] linear RGB in units of value, or NULL */
    const char *quantity;   /* "illuminance" */
    const char *unit;       /* "lx" */
    const char *flux_unit;  /* "lm" */
    double flux, flux_error;
    double mean, mean_error; /* flux per whole area or solid angle */
    double peak;             /* largest value; 0 when nothing was registered */
    uint32_t peak_cell[2];
    double peak_x, peak_y; /* centre of that cell, in the detector's coordinates; else NaN */
    double registrations;
    struct rmap_uniformity *uniformity; /* of the cells, where it was asked for; else NULL */
    struct rmap_detector_share *source; /* [n_source of scene] */
    double centroid[2], rms_radius;     /* of planes, where asked for; else NaN */

    /* Where channels were asked for; 0 and NULL otherwise. */
    size_t n_channel;
    double *cube, *cube_error;                 /* [n_channel][n[1]][n[0]] parts of value */
    double *channel_flux, *channel_flux_error; /* [n_channel] */
};

enum rmap_status rmap_detector_image_create(const struct rmap_map *map,
                                            const struct rmap_detector_sums *sums,
                                            struct rmap_detector_image **image_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;
void rmap_detector_image_destroy(struct rmap_detector_image *image);

/* Fills image->uniformity. */
enum rmap_status rmap_detector_image_find_uniformity(struct rmap_detector_image *image,
                                                     struct rmap_error *err) RMAP_MUST_USE;

/* Centre of cell (i, j) on the detector: over the area in the scene's unit from its centre, over
 * directions theta and phi in degrees. */
void rmap_detector_image_centre(const struct rmap_detector_image *image, uint32_t i, uint32_t j,
                                double *x, double *y);

/* A place on a plane, in the world. */
struct rmap_vec3 rmap_detector_image_place(const struct rmap_detector_image *image, double x,
                                           double y);

/* "mm" or "deg"; "656.27 nm" or "red" of a channel. */
const char *rmap_detector_image_coordinate_unit(const struct rmap_detector_image *image);
void rmap_detector_image_channel(const struct rmap_detector_image *image, size_t channel,
                                 char text[32]);

/* Lines of "# key: value", then i,j,x,y,value,standard_error,rays for every cell, and value and
 * error per channel where there are any. criterion: NULL for all rays. */
void rmap_detector_image_csv(const struct rmap_detector_image *image, const char *criterion,
                             FILE *out);

/* The sums for people, and as a JSON object (new reference; NULL when memory is short). */
void rmap_detector_image_print(const struct rmap_detector_image *image, const char *criterion,
                               FILE *out);

/* A line of a number with what it is without the cells' noise; and least, greatest, percentiles and
 * uniformity in a JSON object. */
void rmap_biased_print(const char *name, const struct rmap_biased *of, const char *unit, FILE *out);
void rmap_uniformity_describe(const struct rmap_uniformity *of, json_t *document);

/* For people, a row per source. */
enum rmap_status rmap_detector_image_print_sources(const struct rmap_detector_image *image,
                                                   FILE *out, struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_detector_image_json(const struct rmap_detector_image *image, const char *criterion);

#endif
