/* SPDX-License-Identifier: MIT
 *
 * A detector's image in physical units, and what people ask of it: total, mean, peak, errors.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/detector/detector_image.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/flux_error.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "optics/spectrum.h"
#include "portion/weight.h"

static void name_units(struct rmap_detector_image *image, const struct rmap_detector_ask *ask)
{
    static const char *const name[][2] = {
        [RMAP_PER_AREA] = {"irradiance", "illuminance"},
        [RMAP_PER_SOLID_ANGLE] = {"radiant intensity", "luminous intensity"},
        [RMAP_PER_AREA_AND_ANGLE] = {"radiance", "luminance"},
        [RMAP_PER_CELL] = {"flux per cell", "flux per cell"}};
    const bool lumens = rmap_detector_ask_lumens(ask);
    const enum rmap_flux_unit flux = lumens ? RMAP_FLUX_LM : rmap_map_scene(ask->map)->flux_unit;
    image->flux_unit = rmap_image_unit_usual(RMAP_PER_CELL, flux)->name;
    image->quantity = name[image->bins.quantity][lumens];
    image->unit = (ask->unit ? ask->unit : rmap_image_unit_usual(image->bins.quantity, flux))->name;
    if (strcmp(image->unit, "%") == 0)
        image->quantity = "daylight factor";
}

/* Sources of an image, [first, last). */
struct sources {
    size_t first, last;
};

/* What is seen of all light, where not all of it counts alike. */
static void seen_value(const struct rmap_detector_sums *sums, struct sources of, size_t c,
                       double *value, double *error)
{
    if (sums->n_seen)
        rmap_detector_sums_channel(sums, of.first, of.last, sums->n_spectral, c, value, error);
}

/* What a part of a flux's colour is in the unit of values: of W that are told in lm, lm/W. */
static double colour_unit(const struct rmap_detector_ask *ask)
{
    return rmap_detector_ask_lumens(ask) && rmap_map_scene(ask->map)->flux_unit == RMAP_FLUX_W
               ? RMAP_LUMENS_PER_WATT
               : 1.0;
}

static void fill_cells(struct rmap_detector_image *image, const struct rmap_map *map,
                       const struct rmap_detector_sums *sums)
{
    for (size_t c = 0; c < sums->n_cell; c++) {
        double flux = 0.0, variance = 0.0;
        for (size_t s = 0; s < sums->n_source; s++) {
            const double *w = sums->weight + s * sums->n_cell + c;
            rmap_detector_sums_add_flux(map, s, w[0], w[sums->n_source * sums->n_cell], &flux,
                                        &variance);
            image->rays[c] += w[0];
        }
        uint32_t i = (uint32_t)(c % image->n[0]);
        double extent = rmap_detector_bins_extent(&image->bins, c),
               error = rmap_flux_error(variance);
        seen_value(sums, (struct sources){0, sums->n_source}, c, &flux, &error);
        image->value[c] = flux / extent;
        image->standard_error[c] = error / extent;
        image->registrations += image->rays[c];
        for (size_t k = 0; k < 3 && sums->n_colour; k++)
            image->rgb[3 * c + k] =
                (double)sums->colour[3 * c + k] * sums->quantum * colour_unit(&sums->ask) / extent;
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

/* Flux of these sources together. */
static void total_of(const struct rmap_map *map, const struct rmap_detector_sums *sums,
                     struct sources of, struct rmap_detector_share *total)
{
    double variance = 0.0;
    *total = (struct rmap_detector_share){0.0, 0.0, 0.0};
    for (size_t s = of.first; s < of.last; s++)
        rmap_detector_sums_add_flux(map, s, sums->total[s], sums->total[sums->n_source + s],
                                    &total->flux, &variance);
    total->flux_error = rmap_flux_error(variance);
    seen_value(sums, of, sums->n_cell, &total->flux, &total->flux_error);
}

static void fill_totals(struct rmap_detector_image *image, const struct rmap_map *map,
                        const struct rmap_detector_sums *sums)
{
    struct rmap_detector_share all;
    double extent = rmap_detector_bins_whole(&image->bins);
    total_of(map, sums, (struct sources){0, sums->n_source}, &all);
    for (size_t s = 0; s < sums->n_source; s++) {
        total_of(map, sums, (struct sources){s, s + 1}, &image->source[s]);
        for (size_t c = 0; c < sums->n_cell; c++)
            image->source[s].registrations += sums->weight[s * sums->n_cell + c];
    }
    image->flux = all.flux;
    image->flux_error = all.flux_error;
    image->mean = image->flux / extent;
    image->mean_error = image->flux_error / extent;
    image->peak_x = image->peak_y = (double)NAN;
    if (image->peak > 0.0)
        rmap_detector_image_centre(image, image->peak_cell[0], image->peak_cell[1], &image->peak_x,
                                   &image->peak_y);
    fill_centroid(image, map, sums);
}

/* A channel's flux in a cell, or in all: of sums for `xyz`, which are of light as it arrives, as
 * the response has it. */
static void channel_value(const struct rmap_detector_sums *sums, size_t channel, size_t c,
                          double *value, double *error)
{
    const struct rmap_detector_ask *ask = &sums->ask;
    const double seen =
        ask->xyz && ask->weighed ? ask->bins.detector->response->value[channel] : 1.0;
    rmap_detector_sums_channel(sums, 0, sums->n_source, channel, c, value, error);
    *value *= seen;
    *error *= seen;
}

static enum rmap_status fill_channels(struct rmap_detector_image *image,
                                      const struct rmap_detector_sums *sums, struct rmap_error *err)
{
    const size_t n = sums->n_cell, n_channel = sums->ask.channels ? sums->n_spectral : 0;
    if (n_channel == 0)
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
            double extent = rmap_detector_bins_extent(&image->bins, c);
            channel_value(sums, k, c, &image->cube[k * n + c], &image->cube_error[k * n + c]);
            image->cube[k * n + c] /= extent;
            image->cube_error[k * n + c] /= extent;
        }
        channel_value(sums, k, n, &image->channel_flux[k], &image->channel_flux_error[k]);
    }
    return RMAP_OK;
}

static void divide(double *value, size_t n, double by)
{
    for (size_t i = 0; value && i < n; i++)
        value[i] /= by;
}

/* Values, not fluxes. */
static void change_unit(struct rmap_detector_image *image, double size, size_t n_colour)
{
    const size_t n = (size_t)image->n[0] * image->n[1];
    divide(image->value, n, size);
    divide(image->standard_error, n, size);
    divide(image->rgb, n_colour, size);
    divide(image->cube, n * image->n_channel, size);
    divide(image->cube_error, n * image->n_channel, size);
    divide(&image->mean, 1, size);
    divide(&image->mean_error, 1, size);
    divide(&image->peak, 1, size);
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
        image->source = rmap_alloc(sums->n_source + 1, sizeof *image->source);
        image->rgb = sums->n_colour ? rmap_alloc(sums->n_colour, sizeof *image->rgb) : NULL;
    }
    if (!image || !image->source || !image->value || !image->standard_error || !image->rays ||
        (sums->n_colour && !image->rgb)) {
        rmap_detector_image_destroy(image);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an image of %zu cells",
                              sums->n_cell);
    }
    name_units(image, &sums->ask);
    rmap_map_dim_text(map, image->dimmed);
    fill_cells(image, map, sums);
    fill_totals(image, map, sums);
    RMAP_TRY(fill_channels(image, sums, err));
    if (sums->ask.xyz)
        RMAP_TRY(rmap_detector_colour_create(sums, &image->colour, err));
    if (sums->ask.unit)
        change_unit(image, sums->ask.unit->size, sums->n_colour);
    *image_ret = image;
    image = NULL;
out:
    rmap_detector_image_destroy(image);
    return st;
}

enum rmap_status rmap_detector_image_find_uniformity(struct rmap_detector_image *image,
                                                     struct rmap_error *err)
{
    image->uniformity = rmap_alloc(1, sizeof *image->uniformity);
    if (!image->uniformity)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the uniformity of an image");
    return rmap_uniformity_find(image->value, image->standard_error,
                                (size_t)image->n[0] * image->n[1], image->mean, image->uniformity,
                                err);
}

void rmap_detector_image_destroy(struct rmap_detector_image *image)
{
    if (!image)
        return;
    rmap_free(image->value);
    rmap_free(image->standard_error);
    rmap_free(image->rays);
    rmap_free(image->source);
    rmap_free(image->uniformity);
    rmap_detector_colour_destroy(image->colour);
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

struct rmap_vec3 rmap_detector_image_place(const struct rmap_detector_image *image, double x,
                                           double y)
{
    const struct rmap_detector *detector = image->detector;
    return rmap_axpy(x, detector->x, rmap_axpy(y, detector->y, detector->origin));
}

/* A detector's image as text: CSV, sums for people, JSON. */

const char *rmap_detector_image_coordinate_unit(const struct rmap_detector_image *image)
{
    return image->bins.directions ? "deg" : image->bins.camera ? "tan" : image->scene->unit;
}

void rmap_detector_image_channel(const struct rmap_detector_image *image, size_t channel,
                                 char text[32])
{
    static const char *const rgb[] = {"red", "green", "blue"};
    const struct rmap_channels *channels = &image->scene->channels;
    if (channels->mode == RMAP_COLOUR_RGB)
        (void)snprintf(text, 32, "%s", rgb[channel % 3]);
    else
        (void)snprintf(text, 32, "%.10g nm", channels->wavelength_nm[channel]);
}

void rmap_detector_image_csv(const struct rmap_detector_image *image, const char *criterion,
                             FILE *out)
{
    bool plane = !image->bins.directions;
    fprintf(out, "# detector: %s\n# quantity: %s, %s\n", image->detector->name, image->quantity,
            image->unit);
    fprintf(out, "# %s: cell centres%s, %s\n",
            image->world ? "x, y, z"
            : plane      ? "x, y"
                         : "theta, phi",
            image->world ? " in the world" : "", rmap_detector_image_coordinate_unit(image));
    fprintf(out, "# criterion: %s\n", criterion ? criterion : "all");
    rmap_which_csv(image->which, out);
    if (image->dimmed[0])
        fprintf(out, "# dimmed: %s\n", image->dimmed);
    fprintf(out, "# flux: %.17g %s\n", image->flux, image->flux_unit);
    fprintf(out, "i,j,%s,value,standard_error,rays",
            image->world ? "x,y,z"
            : plane      ? "x,y"
                         : "theta,phi");
    for (size_t k = 0; k < image->n_channel; k++) {
        char channel[32];
        rmap_detector_image_channel(image, k, channel);
        fprintf(out, ",value at %s,standard_error at %s", channel, channel);
    }
    for (int k = 0; k < RMAP_COLOUR_NUMBERS && image->colour; k++)
        fprintf(out, ",%s", rmap_colour_number[k]);
    fputc('\n', out);
    for (uint32_t j = 0; j < image->n[1]; j++)
        for (uint32_t i = 0; i < image->n[0]; i++) {
            size_t c = i + (size_t)j * image->n[0];
            double x, y;
            rmap_detector_image_centre(image, i, j, &x, &y);
            const struct rmap_vec3 p = rmap_detector_image_place(image, x, y);
            fprintf(out, "%u,%u", i, j);
            rmap_csv_put_number(image->world ? p.x : x, out);
            rmap_csv_put_number(image->world ? p.y : y, out);
            if (image->world)
                rmap_csv_put_number(p.z, out);
            rmap_csv_put_estimate(image->value[c], image->standard_error[c], out);
            rmap_csv_put_number(image->rays[c], out);
            for (size_t k = 0; k < image->n_channel; k++) {
                rmap_csv_put_estimate(image->cube[k * image->n[0] * image->n[1] + c],
                                      image->cube_error[k * image->n[0] * image->n[1] + c], out);
            }
            for (int k = 0; k < RMAP_COLOUR_NUMBERS && image->colour; k++)
                rmap_csv_put_number(rmap_colour_number_of(&image->colour->cell[c], k), out);
            fputc('\n', out);
        }
}

static void print_sum(const char *name, double value, double error, const char *unit, FILE *out)
{
    fprintf(out, "%-14s %.9g", name, value);
    if (isfinite(error))
        fprintf(out, " +- %.3g", error);
    fprintf(out, " %s\n", unit);
}

void rmap_biased_print(const char *name, const struct rmap_biased *of, const char *unit, FILE *out)
{
    fprintf(out, "%-14s %.4g %s", name, of->value, unit);
    if (isfinite(of->standard_error))
        fprintf(out, "; without the cells' noise %.4g +- %.2g", fmax(of->value - of->bias, 0.0),
                of->standard_error);
    fputc('\n', out);
}

static void print_uniformity(const struct rmap_detector_image *image, FILE *out)
{
    const struct rmap_uniformity *of = image->uniformity;
    if (!of || !(image->registrations > 0.0) || image->n[0] * image->n[1] < 2)
        return;
    const size_t n_cell = (size_t)image->n[0] * image->n[1];
    size_t n_empty = 0;
    for (size_t c = 0; c < n_cell; c++)
        n_empty += (size_t) !(image->rays[c] > 0.0);
    rmap_biased_print("least", &of->least, image->unit, out);
    if (n_empty > 0)
        fprintf(out, "%-14s %zu of %zu cells: what is least there, more rays or fewer cells tell\n",
                "empty", n_empty, n_cell);
    fprintf(out, "%-14s", "percentiles");
    for (int k = 0; k < RMAP_PERCENTILES; k++)
        fprintf(out, "%s %d %%: %.4g", k ? "," : "", rmap_percentile[k], of->percentile[k]);
    fprintf(out, " %s\n", image->unit);
    rmap_biased_print("U0", &of->u0, "least / mean", out);
    rmap_biased_print("Ud", &of->ud, "least / greatest", out);
}

void rmap_detector_image_print(const struct rmap_detector_image *image, const char *criterion,
                               FILE *out)
{
    bool plane = !image->bins.directions;
    fprintf(out, "%-14s %s, %u x %u cells\n", "detector", image->detector->name, image->n[0],
            image->n[1]);
    fprintf(out, "%-14s %s\n", "criterion", criterion ? criterion : "all");
    rmap_which_print(image->which, out);
    if (image->dimmed[0])
        fprintf(out, "%-14s %s\n", "dimmed", image->dimmed);
    fprintf(out, "%-14s %" PRIu64 "\n", "registrations", rmap_weight_whole(image->registrations));
    print_sum("flux", image->flux, image->flux_error, image->flux_unit, out);
    fprintf(out, "%-14s %s\n", "quantity", image->quantity);
    print_sum("mean", image->mean, image->mean_error, image->unit, out);
    size_t c = image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0];
    print_sum("peak", image->peak, image->standard_error[c], image->unit, out);
    const struct rmap_vec3 p = rmap_detector_image_place(image, image->peak_x, image->peak_y);
    if (isfinite(image->peak_x) && image->world)
        fprintf(out, "%-14s x %.6g, y %.6g, z %.6g %s in the world (cell %u %u)\n", "peak at", p.x,
                p.y, p.z, image->scene->unit, image->peak_cell[0], image->peak_cell[1]);
    else if (isfinite(image->peak_x))
        fprintf(out, "%-14s %s %.6g, %s %.6g %s (cell %u %u)\n", "peak at", plane ? "x" : "theta",
                image->peak_x, plane ? "y" : "phi", image->peak_y,
                rmap_detector_image_coordinate_unit(image), image->peak_cell[0],
                image->peak_cell[1]);
    print_uniformity(image, out);
    if (image->colour)
        rmap_detector_colour_print(image->colour, out);
    for (size_t k = 0; k < image->n_channel; k++) {
        char channel[32];
        rmap_detector_image_channel(image, k, channel);
        print_sum(channel, image->channel_flux[k], image->channel_flux_error[k], image->flux_unit,
                  out);
    }
    if (image->registrations == 0.0)
        fprintf(out, "%-14s nothing was registered: no ray matches, or none meets the region\n",
                "note");
}

enum rmap_status rmap_detector_image_print_sources(const struct rmap_detector_image *image,
                                                   FILE *out, struct rmap_error *err)
{
    struct rmap_text_table table;
    enum rmap_status st = RMAP_OK;
    static const char *const head[5] = {"source", "registrations", "flux", "standard error",
                                        "share"};
    rmap_text_table_init(&table, 5);
    for (size_t k = 0; k < 5; k++)
        rmap_text_table_add(&table, "%s", head[k]);
    for (size_t s = 0; s < image->scene->n_source; s++) {
        const struct rmap_detector_share *of = &image->source[s];
        rmap_text_table_add(&table, "%s", image->scene->source[s].name);
        rmap_text_table_add(&table, "%" PRIu64, rmap_weight_whole(of->registrations));
        rmap_text_table_add(&table, "%.6g %s", of->flux, image->flux_unit);
        rmap_text_table_add(&table, isfinite(of->flux_error) ? "%.2g" : "-", of->flux_error);
        rmap_text_table_add(&table, "%.4g %%",
                            image->flux > 0.0 ? 100.0 * of->flux / image->flux : 0.0);
    }
    st = rmap_text_table_print(&table, "lrrrr", out, err);
    rmap_text_table_fini(&table);
    return st;
}

/* Degrees as they were asked for: 30, not 29.999999999999996. */
static double degrees(double rad)
{
    return rint(rad * 180.0 / RMAP_PI * 1e9) / 1e9;
}

/* What differs from the detector as it stands in the scene. */
static void describe_bins(const struct rmap_detector_image *image, json_t *document)
{
    const struct rmap_detector_bins *bins = &image->bins;
    const double unit = bins->directions ? 180.0 / RMAP_PI : 1.0;
    if (bins->stored || bins->camera)
        return;
    (void)json_object_set_new(
        document, "region",
        json_pack("{s:s, s:[f, f], s:[f, f], s:f, s:s}", "over",
                  bins->directions ? "direction" : "area", bins->directions ? "theta" : "x",
                  bins->low[0] * unit, bins->high[0] * unit, bins->directions ? "phi" : "y",
                  bins->low[1] * unit, bins->high[1] * unit, "rotate", degrees(bins->rotate_rad),
                  "unit", rmap_detector_image_coordinate_unit(image)));
}

static void describe_channels(const struct rmap_detector_image *image, json_t *document)
{
    json_t *list = image->n_channel ? json_array() : NULL;
    for (size_t k = 0; k < image->n_channel; k++) {
        char channel[32];
        rmap_detector_image_channel(image, k, channel);
        (void)json_array_append_new(
            list, json_pack("{s:s, s:o, s:o}", "channel", channel, "flux",
                            rmap_json_number(image->channel_flux[k]), "standard_error",
                            rmap_json_number(image->channel_flux_error[k])));
    }
    if (list)
        (void)json_object_set_new(document, "spectrum", list);
}

static json_t *biased_json(const struct rmap_biased *of)
{
    return json_pack("{s:o, s:o, s:o}", "value", rmap_json_number(of->value), "standard_error",
                     rmap_json_number(of->standard_error), "bias", rmap_json_number(of->bias));
}

void rmap_uniformity_describe(const struct rmap_uniformity *of, json_t *document)
{
    json_t *percentiles = json_array();
    for (int k = 0; k < RMAP_PERCENTILES; k++)
        (void)json_array_append_new(percentiles,
                                    json_pack("{s:i, s:o}", "percent", rmap_percentile[k], "value",
                                              rmap_json_number(of->percentile[k])));
    (void)json_object_set_new(document, "least", biased_json(&of->least));
    (void)json_object_set_new(document, "greatest", biased_json(&of->greatest));
    (void)json_object_set_new(document, "percentiles", percentiles);
    (void)json_object_set_new(
        document, "uniformity",
        json_pack("{s:o, s:o}", "U0", biased_json(&of->u0), "Ud", biased_json(&of->ud)));
}

static void describe_sources(const struct rmap_detector_image *image, json_t *document)
{
    json_t *sources = json_array();
    for (size_t s = 0; s < image->scene->n_source; s++) {
        const struct rmap_detector_share *share = &image->source[s];
        (void)json_array_append_new(
            sources, json_pack("{s:s, s:I, s:o, s:o}", "source", image->scene->source[s].name,
                               "registrations", (json_int_t)rmap_weight_whole(share->registrations),
                               "flux", rmap_json_number(share->flux), "standard_error",
                               rmap_json_number(share->flux_error)));
    }
    (void)json_object_set_new(document, "sources", sources);
}

json_t *rmap_detector_image_json(const struct rmap_detector_image *image, const char *criterion)
{
    size_t c = image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0];
    json_t *peak = json_null();
    const struct rmap_vec3 p = rmap_detector_image_place(image, image->peak_x, image->peak_y);
    if (isfinite(image->peak_x))
        peak = json_pack("{s:o, s:o, s:o, s:o, s:[i, i]}", "value", rmap_json_number(image->peak),
                         "standard_error", rmap_json_number(image->standard_error[c]), "x",
                         rmap_json_number(image->world ? p.x : image->peak_x), "y",
                         rmap_json_number(image->world ? p.y : image->peak_y), "cell",
                         (int)image->peak_cell[0], (int)image->peak_cell[1]);
    if (image->world && peak && !json_is_null(peak))
        (void)json_object_set_new(peak, "z", rmap_json_number(p.z));
    bool plane = image->detector->type == RMAP_DETECTOR_PLANE;
    json_t *document = json_pack(
        "{s:s, s:s, s:[i, i], s:s, s:o, s:I, s:{s:o, s:o, s:s}, s:s, s:s, s:{s:o, s:o}, s:o}",
        "detector", image->detector->name, "type",
        image->bins.camera ? "camera"
        : plane            ? "plane"
                           : "intensity",
        "cells", (int)image->n[0], (int)image->n[1], "criterion", criterion ? criterion : "all",
        "which", rmap_which_json(image->which), "registrations",
        (json_int_t)rmap_weight_whole(image->registrations), "flux", "total",
        rmap_json_number(image->flux), "standard_error", rmap_json_number(image->flux_error),
        "unit", image->flux_unit, "quantity", image->quantity, "unit", image->unit, "mean", "value",
        rmap_json_number(image->mean), "standard_error", rmap_json_number(image->mean_error),
        "peak", peak);
    if (!document)
        return NULL;
    if (image->world)
        (void)json_object_set_new(document, "frame", json_string("world"));
    if (image->uniformity)
        rmap_uniformity_describe(image->uniformity, document);
    describe_sources(image, document);
    describe_bins(image, document);
    describe_channels(image, document);
    if (image->colour)
        (void)json_object_set_new(document, "colour", rmap_detector_colour_json(image->colour));
    if (image->registrations == 0.0)
        (void)json_object_set_new(document, "note", json_string("nothing was registered"));
    return document;
}
