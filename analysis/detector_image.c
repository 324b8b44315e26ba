/* SPDX-License-Identifier: MIT */
#include "analysis/detector_image.h"

#include <math.h>

#include "analysis/ray_report.h"
#include "base/alloc.h"
#include "optics/spectrum.h"
#include "trace/tally.h"

/* Area of a cell in m2, or its solid angle in sr; i counts theta there. */
static double cell_extent(const struct rmap_scene *scene, const struct rmap_detector *detector,
                          uint32_t i)
{
    double nx = detector->cells[0], ny = detector->cells[1];
    if (detector->type == RMAP_DETECTOR_PLANE)
        return detector->size[0] / nx * detector->size[1] / ny * scene->unit_m * scene->unit_m;
    /* cos a - cos b, without the cancellation near the poles */
    double a = RMAP_PI * i / nx, b = RMAP_PI * (i + 1) / nx;
    return 2.0 * sin(0.5 * (a + b)) * sin(0.5 * (b - a)) * 2.0 * RMAP_PI / ny;
}

static double whole_extent(const struct rmap_scene *scene, const struct rmap_detector *detector)
{
    if (detector->type == RMAP_DETECTOR_INTENSITY)
        return 4.0 * RMAP_PI;
    return detector->size[0] * detector->size[1] * scene->unit_m * scene->unit_m;
}

static void name_units(struct rmap_detector_image *image)
{
    bool lumens = image->scene->flux_unit == RMAP_FLUX_LM;
    bool plane = image->detector->type == RMAP_DETECTOR_PLANE;
    image->flux_unit = lumens ? "lm" : "W";
    if (plane) {
        image->quantity = lumens ? "illuminance" : "irradiance";
        image->unit = lumens ? "lx" : "W/m2";
    } else {
        image->quantity = lumens ? "luminous intensity" : "radiant intensity";
        image->unit = lumens ? "cd" : "W/sr";
    }
}

/* Flux of one source's sums, and its part of the variance. */
static void add_flux(const struct rmap_map *map, size_t source, double w, double w2, double *flux,
                     double *variance)
{
    double n = rmap_map_emitted(map)[source];
    double unit = rmap_map_flux_per_weight(map)[source];
    *flux += unit * w;
    *variance += n < 2 ? (double)NAN : unit * unit * n / (n - 1) * (w2 - w * w / n);
}

static void fill_cells(struct rmap_detector_image *image, const struct rmap_map *map,
                       const struct rmap_detector_sums *sums)
{
    for (size_t c = 0; c < sums->n_cell; c++) {
        double flux = 0.0, variance = 0.0;
        for (size_t s = 0; s < sums->n_source; s++) {
            const double *w = sums->weight + s * sums->n_cell + c;
            add_flux(map, s, w[0], w[sums->n_source * sums->n_cell], &flux, &variance);
            image->rays[c] += w[0];
        }
        uint32_t i = (uint32_t)(c % image->n[0]);
        double extent = cell_extent(image->scene, image->detector, i);
        image->value[c] = flux / extent;
        image->standard_error[c] =
            isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0)) / extent;
        image->registrations += image->rays[c];
        for (size_t k = 0; k < 3 && sums->n_colour; k++)
            image->rgb[3 * c + k] = (double)sums->colour[3 * c + k] * sums->quantum / extent;
        if (sums->n_colour && image->scene->channels.mode == RMAP_COLOUR_SPECTRAL)
            rmap_xyz_to_rgb(
                (const double[3]){image->rgb[3 * c], image->rgb[3 * c + 1], image->rgb[3 * c + 2]},
                image->rgb + 3 * c);
        if (image->value[c] > image->peak) {
            image->peak = image->value[c];
            image->peak_cell[0] = i;
            image->peak_cell[1] = (uint32_t)(c / image->n[0]);
        }
    }
}

static void fill_totals(struct rmap_detector_image *image, const struct rmap_map *map,
                        const struct rmap_detector_sums *sums)
{
    double variance = 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        double w = 0.0, w2 = 0.0;
        for (size_t c = 0; c < sums->n_cell; c++) {
            w += sums->weight[s * sums->n_cell + c];
            w2 += sums->weight[(sums->n_source + s) * sums->n_cell + c];
        }
        add_flux(map, s, w, w2, &image->flux, &variance);
    }
    double extent = whole_extent(image->scene, image->detector);
    image->flux_error = isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0));
    image->mean = image->flux / extent;
    image->mean_error = image->flux_error / extent;
    image->peak_x = image->peak_y = (double)NAN;
    if (image->peak > 0.0)
        rmap_detector_image_centre(image, image->peak_cell[0], image->peak_cell[1], &image->peak_x,
                                   &image->peak_y);
}

enum rmap_status rmap_detector_image_create(const struct rmap_map *map,
                                            const struct rmap_detector_sums *sums,
                                            struct rmap_detector_image **image_ret,
                                            struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_detector_image *image = rmap_alloc(1, sizeof *image);
    if (image) {
        image->scene = scene;
        image->detector = &scene->detector[sums->detector];
        image->n[0] = image->detector->cells[0];
        image->n[1] = image->detector->cells[1];
        image->value = rmap_alloc(sums->n_cell, sizeof *image->value);
        image->standard_error = rmap_alloc(sums->n_cell, sizeof *image->standard_error);
        image->rays = rmap_alloc(sums->n_cell, sizeof *image->rays);
        image->rgb = sums->n_colour ? rmap_alloc(sums->n_colour, sizeof *image->rgb) : NULL;
    }
    if (!image || !image->value || !image->standard_error || !image->rays ||
        (sums->n_colour && !image->rgb)) {
        rmap_detector_image_destroy(image);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an image of %zu cells",
                              sums->n_cell);
    }
    name_units(image);
    fill_cells(image, map, sums);
    fill_totals(image, map, sums);
    *image_ret = image;
    return RMAP_OK;
}

void rmap_detector_image_destroy(struct rmap_detector_image *image)
{
    if (!image)
        return;
    rmap_free(image->value);
    rmap_free(image->standard_error);
    rmap_free(image->rays);
    rmap_free(image->rgb);
    rmap_free(image);
}

void rmap_detector_image_centre(const struct rmap_detector_image *image, uint32_t i, uint32_t j,
                                double *x, double *y)
{
    const double relative[2] = {(i + 0.5) / image->n[0], (j + 0.5) / image->n[1]};
    rmap_detector_coordinates(image->detector, relative, x, y);
}
