/* SPDX-License-Identifier: MIT
 *
 * A detector's image as text: CSV, sums for people, JSON.
 */
#include <math.h>

#include "analysis/detector/detector_image.h"
#include "analysis/table/csv_field.h"
#include "io/export/json_number.h"

const char *rmap_detector_image_coordinate_unit(const struct rmap_detector_image *image)
{
    return image->bins.directions ? "deg" : image->scene->unit;
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
    fprintf(out, "# %s, %s: cell centres, %s\n", plane ? "x" : "theta", plane ? "y" : "phi",
            rmap_detector_image_coordinate_unit(image));
    fprintf(out, "# criterion: %s\n", criterion ? criterion : "all");
    rmap_which_csv(image->which, out);
    fprintf(out, "# flux: %.17g %s\n", image->flux, image->flux_unit);
    fprintf(out, "i,j,%s,value,standard_error,rays", plane ? "x,y" : "theta,phi");
    for (size_t k = 0; k < image->n_channel; k++) {
        char channel[32];
        rmap_detector_image_channel(image, k, channel);
        fprintf(out, ",value at %s,standard_error at %s", channel, channel);
    }
    fputc('\n', out);
    for (uint32_t j = 0; j < image->n[1]; j++)
        for (uint32_t i = 0; i < image->n[0]; i++) {
            size_t c = i + (size_t)j * image->n[0];
            double x, y;
            rmap_detector_image_centre(image, i, j, &x, &y);
            fprintf(out, "%u,%u", i, j);
            rmap_csv_put_number(x, out);
            rmap_csv_put_number(y, out);
            rmap_csv_put_number(image->value[c], out);
            rmap_csv_put_number(image->standard_error[c], out);
            rmap_csv_put_number(image->rays[c], out);
            for (size_t k = 0; k < image->n_channel; k++) {
                rmap_csv_put_number(image->cube[k * image->n[0] * image->n[1] + c], out);
                rmap_csv_put_number(image->cube_error[k * image->n[0] * image->n[1] + c], out);
            }
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

void rmap_detector_image_print(const struct rmap_detector_image *image, const char *criterion,
                               FILE *out)
{
    bool plane = !image->bins.directions;
    fprintf(out, "%-14s %s, %u x %u cells\n", "detector", image->detector->name, image->n[0],
            image->n[1]);
    fprintf(out, "%-14s %s\n", "criterion", criterion ? criterion : "all");
    rmap_which_print(image->which, out);
    fprintf(out, "%-14s %.17g\n", "registrations", image->registrations);
    print_sum("flux", image->flux, image->flux_error, image->flux_unit, out);
    fprintf(out, "%-14s %s\n", "quantity", image->quantity);
    print_sum("mean", image->mean, image->mean_error, image->unit, out);
    size_t c = image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0];
    print_sum("peak", image->peak, image->standard_error[c], image->unit, out);
    if (isfinite(image->peak_x))
        fprintf(out, "%-14s %s %.6g, %s %.6g %s (cell %u %u)\n", "peak at", plane ? "x" : "theta",
                image->peak_x, plane ? "y" : "phi", image->peak_y,
                rmap_detector_image_coordinate_unit(image), image->peak_cell[0],
                image->peak_cell[1]);
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
    if (bins->stored)
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

json_t *rmap_detector_image_json(const struct rmap_detector_image *image, const char *criterion)
{
    size_t c = image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0];
    json_t *peak = json_null();
    if (isfinite(image->peak_x))
        peak = json_pack("{s:o, s:o, s:o, s:o, s:[i, i]}", "value", rmap_json_number(image->peak),
                         "standard_error", rmap_json_number(image->standard_error[c]), "x",
                         rmap_json_number(image->peak_x), "y", rmap_json_number(image->peak_y),
                         "cell", (int)image->peak_cell[0], (int)image->peak_cell[1]);
    bool plane = image->detector->type == RMAP_DETECTOR_PLANE;
    json_t *document = json_pack(
        "{s:s, s:s, s:[i, i], s:s, s:o, s:I, s:{s:o, s:o, s:s}, s:s, s:s, s:{s:o, s:o}, s:o}",
        "detector", image->detector->name, "type", plane ? "plane" : "intensity", "cells",
        (int)image->n[0], (int)image->n[1], "criterion", criterion ? criterion : "all", "which",
        rmap_which_json(image->which), "registrations", (json_int_t)llround(image->registrations),
        "flux", "total", rmap_json_number(image->flux), "standard_error",
        rmap_json_number(image->flux_error), "unit", image->flux_unit, "quantity", image->quantity,
        "unit", image->unit, "mean", "value", rmap_json_number(image->mean), "standard_error",
        rmap_json_number(image->mean_error), "peak", peak);
    if (!document)
        return NULL;
    describe_bins(image, document);
    describe_channels(image, document);
    if (image->registrations == 0.0)
        (void)json_object_set_new(document, "note", json_string("nothing was registered"));
    return document;
}
