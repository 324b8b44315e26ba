/* SPDX-License-Identifier: MIT */
#include "analysis/detector/detector_image.h"

#include <math.h>

#include "base/alloc.h"
#include "optics/spectrum.h"

static void name_units(struct rmap_detector_image *image, bool luminous)
{
    static const char *const name[][2] = {
        [RMAP_PER_AREA] = {"irradiance", "illuminance"},
        [RMAP_PER_SOLID_ANGLE] = {"radiant intensity", "luminous intensity"},
        [RMAP_PER_AREA_AND_ANGLE] = {"radiance", "luminance"},
        [RMAP_PER_CELL] = {"flux per cell", "flux per cell"}};
    static const char *const unit[][2] = {[RMAP_PER_AREA] = {"W/m2", "lx"},
                                          [RMAP_PER_SOLID_ANGLE] = {"W/sr", "cd"},
                                          [RMAP_PER_AREA_AND_ANGLE] = {"W/(m2 sr)", "cd/m2"},
                                          [RMAP_PER_CELL] = {"W", "lm"}};
    const int lumens = luminous || image->scene->flux_unit == RMAP_FLUX_LM;
    image->flux_unit = unit[RMAP_PER_CELL][lumens];
    image->quantity = name[image->bins.quantity][lumens];
    image->unit = unit[image->bins.quantity][lumens];
}

/* Flux of one source's sums, and its part of the variance. */
static void add_flux(const struct rmap_map *map, size_t source, double w, double w2, double *flux,
                     double *variance)
{
    double n = rmap_map_emitted(map)[source];
    double unit = rmap_map_flux_per_weight(map)[source];
    double spread = w2 - w * w / n;
    *flux += rmap_map_flux(map, source, w);
    /* Below 0 beyond rounding: a tally with more registrations than rays, which cannot be of a ray
     * each. Of how many they are it does not know, so neither the error. */
    const int known = n >= 2 && spread >= -1e-9 * w2;
    *variance += known ? unit * unit * n / (n - 1) * spread : (double)NAN;
}

static double error_of(double variance)
{
    return isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0));
}

/* Cell c of a channel, or behind the cells its total: flux and standard error. */
static void channel_value(const struct rmap_map *map, const struct rmap_detector_sums *sums,
                          size_t channel, size_t c, double *value, double *error)
{
    double variance = 0.0;
    *value = 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        const uint64_t *share =
            sums->share + (s * sums->n_channel + channel) * (sums->n_cell + 1) + c;
        add_flux(map, s, (double)share[0] / 65535.0,
                 (double)share[sums->n_share / 2] / (65535.0 * 65535.0), value, &variance);
    }
    *error = error_of(variance);
}

/* The same of what is seen of it, in lm. */
static void luminous_value(const struct rmap_map *map, const struct rmap_detector_sums *sums,
                           size_t c, double *value, double *error)
{
    channel_value(map, sums, 0, c, value, error);
    *value *= sums->luminous_unit;
    *error *= sums->luminous_unit;
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
        double extent = rmap_detector_bins_extent(&image->bins, i), error = error_of(variance);
        if (sums->ask.luminous)
            luminous_value(map, sums, c, &flux, &error);
        image->value[c] = flux / extent;
        image->standard_error[c] = error / extent;
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

static void fill_centroid(struct rmap_detector_image *image, const struct rmap_map *map,
                          const struct rmap_detector_sums *sums)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    image->centroid[0] = image->centroid[1] = image->rms_radius = (double)NAN;
    for (size_t s = 0; sums->centre && s < sums->n_source; s++)
        for (size_t k = 0; k < 4; k++)
            sum[k] +=
                rmap_map_flux_per_weight(map)[s] * rmap_exact_sum_value(&sums->centre[4 * s + k]);
    for (int k = 0; k < 2 && sum[0] > 0.0; k++)
        image->centroid[k] = sum[k + 1] / sum[0];
    if (sum[0] > 0.0)
        image->rms_radius = sqrt(fmax(sum[3] / sum[0] - image->centroid[0] * image->centroid[0] -
                                          image->centroid[1] * image->centroid[1],
                                      0.0));
}

static void fill_totals(struct rmap_detector_image *image, const struct rmap_map *map,
                        const struct rmap_detector_sums *sums)
{
    double variance = 0.0;
    for (size_t s = 0; s < sums->n_source; s++)
        add_flux(map, s, sums->total[s], sums->total[sums->n_source + s], &image->flux, &variance);
    double extent = rmap_detector_bins_whole(&image->bins);
    image->flux_error = error_of(variance);
    if (sums->ask.luminous)
        luminous_value(map, sums, sums->n_cell, &image->flux, &image->flux_error);
    image->mean = image->flux / extent;
    image->mean_error = image->flux_error / extent;
    image->peak_x = image->peak_y = (double)NAN;
    if (image->peak > 0.0)
        rmap_detector_image_centre(image, image->peak_cell[0], image->peak_cell[1], &image->peak_x,
                                   &image->peak_y);
    fill_centroid(image, map, sums);
}

static enum rmap_status fill_channels(struct rmap_detector_image *image, const struct rmap_map *map,
                                      const struct rmap_detector_sums *sums, struct rmap_error *err)
{
    const size_t n = sums->n_cell, n_channel = sums->n_channel;
    if (n_channel == 0 || sums->ask.luminous)
        return RMAP_OK;
    image->n_channel = n_channel;
    image->cube = rmap_alloc(n * n_channel, sizeof *image->cube);
    image->cube_error = rmap_alloc(n * n_channel, sizeof *image->cube_error);
    image->channel_flux = rmap_alloc(n_channel, sizeof *image->channel_flux);
    image->channel_flux_error = rmap_alloc(n_channel, sizeof *image->channel_flux_error);
    if (!image->cube || !image->cube_error || !image->channel_flux || !image->channel_flux_error)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a spectral image");
    for (size_t k = 0; k < n_channel; k++) {
        for (size_t c = 0; c < n; c++) {
            double extent = rmap_detector_bins_extent(&image->bins, (uint32_t)(c % image->n[0]));
            channel_value(map, sums, k, c, &image->cube[k * n + c], &image->cube_error[k * n + c]);
            image->cube[k * n + c] /= extent;
            image->cube_error[k * n + c] /= extent;
        }
        channel_value(map, sums, k, n, &image->channel_flux[k], &image->channel_flux_error[k]);
    }
    return RMAP_OK;
}

enum rmap_status rmap_detector_image_create(const struct rmap_map *map,
                                            const struct rmap_detector_sums *sums,
                                            struct rmap_detector_image **image_ret,
                                            struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_image *image = rmap_alloc(1, sizeof *image);
    if (image) {
        image->scene = scene;
        image->bins = sums->ask.bins;
        image->detector = image->bins.detector;
        image->n[0] = image->bins.n[0];
        image->n[1] = image->bins.n[1];
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
    name_units(image, sums->ask.luminous);
    fill_cells(image, map, sums);
    fill_totals(image, map, sums);
    RMAP_TRY(fill_channels(image, map, sums, err));
    *image_ret = image;
    image = NULL;
out:
    rmap_detector_image_destroy(image);
    return st;
}

void rmap_detector_image_destroy(struct rmap_detector_image *image)
{
    if (!image)
        return;
    rmap_free(image->value);
    rmap_free(image->standard_error);
    rmap_free(image->rays);
    rmap_free(image->rgb);
    rmap_free(image->cube);
    rmap_free(image->cube_error);
    rmap_free(image->channel_flux);
    rmap_free(image->channel_flux_error);
    rmap_free(image);
}

void rmap_detector_image_centre(const struct rmap_detector_image *image, uint32_t i, uint32_t j,
                                double *x, double *y)
{
    rmap_detector_bins_centre(&image->bins, i, j, x, y);
}
