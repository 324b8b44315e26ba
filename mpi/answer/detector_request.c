/* SPDX-License-Identifier: MIT */
#include "mpi/answer/detector_request.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/registration_response.h"
#include "analysis/detector/far_field.h"
#include "analysis/detector/lux_table.h"
#include "base/alloc.h"
#include "mpi/answer/detector_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/dim.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/luminous.h"
#include "mpi/command/output.h"

enum { TABLE_MOST = 100000 };

static enum rmap_status read_bins(const struct rmap_arguments *given,
                                  struct rmap_detector_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_bins_asked *bins = &request->bins;
    const char *cells = rmap_argument(given, "cells"), *rotate = rmap_argument(given, "rotate");
    bins->region = rmap_argument(given, "region");
    bins->world = request->world;
    bins->quantity = rmap_argument(given, "quantity");
    bins->over = rmap_argument(given, "over");
    bins->rotate_deg = (double)NAN;
    request->channels = bins->quantity && strcmp(bins->quantity, "spectral") == 0;
    request->daylight = bins->quantity && strcmp(bins->quantity, "daylight_factor") == 0;
    request->auto_cells = cells && strcmp(cells, "auto") == 0;
    request->grid = cells && strcmp(cells, "en12464") == 0;
    if (cells && !request->auto_cells && !request->grid)
        RMAP_TRY(rmap_read_cells(cells, ", auto or en12464", bins->cells, err));
    if (rotate) {
        char *end = NULL;
        bins->rotate_deg = strtod(rotate, &end);
        if (end == rotate || (*end && strcmp(end, "deg") != 0 && strcmp(end, " deg") != 0) ||
            !isfinite(bins->rotate_deg))
            return rmap_error_set(err, RMAP_USAGE, "--rotate '%.40s' is no angle in degrees",
                                  rotate);
    }
    if (request->tally &&
        (request->where || rmap_argument(given, "which") || cells || rotate || bins->region ||
         bins->quantity || bins->over || request->xyz || rmap_argument(given, "receivers")))
        st = rmap_error_set(err, RMAP_USAGE,
                            "--tally has the detector's own cells and all rays: it goes with none "
                            "of --where, --which, --receivers, --cells, --region, --rotate, "
                            "--quantity, --over and --xyz");
out:
    return st;
}

/* A number greater than 0; 0 where it is not given. */
static enum rmap_status read_positive(const struct rmap_arguments *given, const char *option,
                                      const char *of, double *value_ret, struct rmap_error *err)
{
    const char *text = rmap_argument(given, option);
    char *end = NULL;
    *value_ret = text ? strtod(text, &end) : 0.0;
    if (!text || (end != text && !*end && *value_ret > 0.0 && isfinite(*value_ret)))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE, "--%s '%.40s' is no %s greater than 0", option, text,
                          of);
}

static enum rmap_status read_spot(const struct rmap_arguments *given,
                                  struct rmap_detector_request *request, struct rmap_error *err)
{
    static const char *const suffixes[] = {".png", ".svg", ".csv", NULL};
    const char *frequency = rmap_argument(given, "frequency");
    request->mtf = rmap_argument(given, "mtf") != NULL || frequency;
    request->spot = rmap_argument(given, "spot") != NULL || request->mtf;
    request->plot_path = rmap_argument(given, "plot");
    enum rmap_status st = read_positive(given, "frequency", "number of cycles per unit of length",
                                        &request->frequency, err);
    if (st != RMAP_OK)
        return st;
    if (request->spot && request->tally)
        return rmap_error_set(err, RMAP_USAGE, "--tally knows no places: leave it out for --spot");
    if (!request->plot_path)
        return RMAP_OK;
    return rmap_output_check(request->plot_path, suffixes, request->force, err);
}

static const char lamp_maker[] = "a lamp maker's file";

/* Their cells are centred on the angles of the file, as are those of --photometry. */
static enum rmap_status read_lamp_files(const struct rmap_arguments *given,
                                        struct rmap_detector_request *request,
                                        struct rmap_error *err)
{
    static const char *const other[] = {"tally", "region", "over", "unit"};
    size_t n = 0;
    for (size_t i = 0; i < request->n_output; i++)
        n += rmap_detector_is_lamp_file(request->output[i]);
    request->lamp_file = n > 0;
    const char *what = n > 0 ? lamp_maker : "--photometry";
    if (n == 0 && !request->photometry)
        return RMAP_OK;
    if (n < request->n_output || request->plot_path)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s has cells of its own, about its angles: write pictures and "
                              "numbers by another command",
                              what);
    for (size_t i = 0; i < sizeof other / sizeof *other; i++)
        if (rmap_argument(given, other[i]))
            return rmap_error_set(err, RMAP_USAGE, "%s is of all directions, in cd: leave --%s out",
                                  what, other[i]);
    return request->auto_cells
               ? rmap_error_set(err, RMAP_USAGE,
                                "--cells auto: of %s say how many steps of gamma and planes C, as "
                                "--cells 36x24",
                                what)
               : RMAP_OK;
}

enum rmap_status rmap_detector_request_read(const struct rmap_arguments *given,
                                            struct rmap_detector_request *request,
                                            struct rmap_error *err)
{
    const char *color = rmap_argument(given, "color"), *by = rmap_argument(given, "by");
    const char *frame = rmap_argument(given, "frame");
    *request = (struct rmap_detector_request){
        .map_path = given->operand[0],
        .detector = given->operand[1],
        .where = rmap_argument(given, "where"),
        .unit = rmap_argument(given, "unit"),
        .tally = rmap_argument(given, "tally") != NULL,
        .force = rmap_argument(given, "force") != NULL,
        .by_source = by != NULL,
        .table = rmap_argument(given, "table") != NULL,
        .photometry = rmap_argument(given, "photometry") != NULL,
        .xyz = rmap_argument(given, "xyz") != NULL,
        .world = frame && strcmp(frame, "world") == 0,
    };
    request->figure = (struct rmap_figure_detector){
        .criterion = request->where,
        .isolines = rmap_argument(given, "isolines") != NULL,
        .values = rmap_argument(given, "values") != NULL,
        .true_colour = color && strcmp(color, "true") == 0,
        .scale = rmap_argument(given, "log")      ? RMAP_SCALE_LOGARITHMIC
                 : rmap_argument(given, "linear") ? RMAP_SCALE_LINEAR
                                                  : RMAP_SCALE_AUTO,
    };
    if (rmap_argument(given, "log") && rmap_argument(given, "linear"))
        return rmap_error_set(err, RMAP_USAGE, "say --log or --linear, not both");
    if (color && !request->figure.true_colour && strcmp(color, "false") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--color '%s': say false or true", color);
    if (frame && !request->world && strcmp(frame, "detector") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--frame '%.40s': say detector or world", frame);
    if (rmap_argument(given, "white") && !request->figure.true_colour)
        return rmap_error_set(err, RMAP_USAGE, "--white is of true colour: give --color true");
    enum rmap_status st = read_bins(given, request, err);
    if (st == RMAP_OK)
        st = read_positive(given, "white", "value", &request->figure.white, err);
    if (st == RMAP_OK)
        st = rmap_until_read(given, &request->until, err);
    if (st == RMAP_OK && request->tally && request->until.part.relative > 0.0)
        st = rmap_error_set(err, RMAP_USAGE, "--tally is of all rays: leave --until out");
    if (st == RMAP_OK)
        st = read_spot(given, request, err);
    if (st == RMAP_OK && by && strcmp(by, "source") != 0)
        st = rmap_error_set(err, RMAP_USAGE, "--by '%.40s': say source", by);
    if (st == RMAP_OK)
        st = rmap_argument_each(given, "output", &request->output, &request->n_output, err);
    for (size_t i = 0; i < request->n_output && st == RMAP_OK; i++)
        st = rmap_output_check(request->output[i], rmap_detector_suffixes, request->force, err);
    if (st == RMAP_OK)
        st = read_lamp_files(given, request, err);
    if (st == RMAP_OK)
        st = rmap_argument_numbers(given, "levels", &request->level, &request->figure.n_level, err);
    request->figure.level = request->level;
    if (st == RMAP_OK)
        st = rmap_lamp_sheet_ask(given, &request->sheet, err);
    return st;
}

void rmap_detector_request_fini(struct rmap_detector_request *request)
{
    rmap_until_fini(&request->until);
    rmap_argument_list_free(request->output, request->n_output);
    rmap_free(request->level);
    rmap_lamp_sheet_ask_fini(&request->sheet);
}

enum rmap_status rmap_detector_request_daylight(struct rmap_map *map,
                                                struct rmap_detector_request *request,
                                                struct rmap_error *err)
{
    double horizontal = 0.0;
    enum rmap_status st = rmap_dim_to_daylight(map, &horizontal, err);
    if (st == RMAP_OK && request->unit)
        st = rmap_error_set(err, RMAP_USAGE, "the daylight factor is in %%: leave --unit out");
    request->percent = (struct rmap_image_unit){
        .quantity = RMAP_PER_AREA, .flux = RMAP_FLUX_LM, .name = "%", .size = 0.01 * horizontal};
    return st;
}

/* What the detector's response makes of it. */
static enum rmap_status ask_weighed(const struct rmap_detector *detector,
                                    const struct rmap_detector_request *request,
                                    struct rmap_detector_ask *ask, struct rmap_error *err)
{
    ask->weighed = rmap_detector_weighs(detector);
    if (request->tally && detector->response)
        return rmap_error_set(err, RMAP_USAGE,
                              "--tally: the sums kept during the trace do not know the response of "
                              "'%.60s': leave it out, and the rays are read",
                              detector->name);
    if (ask->weighed && detector->response->lumens)
        ask->luminous = false;
    return ask->weighed && ask->luminous
               ? rmap_error_set(
                     err, RMAP_USAGE,
                     "--quantity illuminance: '%.60s' has a response of its own: give it "
                     "'response: V', or ask for irradiance",
                     detector->name)
               : RMAP_OK;
}

static bool has_spectrum(const struct rmap_scene *scene, const struct rmap_source *source)
{
    return rmap_source_has_spectrum(source) ||
           (source->type == RMAP_SOURCE_STEPS && scene->flux_unit == RMAP_FLUX_PHOTONS);
}

/* The colour of the light, where it is asked for, and of a detector that answers in XYZ where the
 * scene says what it takes. scene: the map's own. */
static enum rmap_status ask_xyz(const struct rmap_scene *scene,
                                const struct rmap_detector *detector,
                                const struct rmap_detector_request *request,
                                struct rmap_detector_ask *ask, struct rmap_error *err)
{
    const bool spectral = scene->channels.mode == RMAP_COLOUR_SPECTRAL;
    size_t said = 0;
    ask->xyz = request->xyz || (detector->response && detector->response->xyz);
    while (said < scene->n_source && (!spectral || has_spectrum(scene, &scene->source[said])))
        said++;
    if (!request->xyz) {
        ask->xyz = ask->xyz && said == scene->n_source;
        return RMAP_OK;
    }
    if (said < scene->n_source)
        return rmap_error_set(err, RMAP_INPUT,
                              "--xyz: the scene does not say the spectrum of source '%.60s': give "
                              "that, and trace anew",
                              scene->source[said].name);
    if (!spectral && scene->flux_unit != RMAP_FLUX_LM)
        return rmap_error_set(err, RMAP_INPUT,
                              "--xyz: red, green and blue in %s are no lm: give fluxes in lm, or "
                              "'mode: spectral', and trace anew",
                              rmap_flux_unit_name(scene));
    return ask->weighed && !detector->response->lumens
               ? rmap_error_set(err, RMAP_USAGE,
                                "--xyz: '%.60s' has a response of its own: give it 'response: "
                                "xyz', or lay a receiver over the map (--receivers)",
                                detector->name)
               : RMAP_OK;
}

/* For a lamp maker's file, or data sheet. */
static enum rmap_status ask_far_field(const struct rmap_scene *scene, bool file,
                                      struct rmap_detector_ask *ask, struct rmap_error *err)
{
    const struct rmap_detector *detector = &scene->detector[ask->detector];
    const char *what = file ? lamp_maker : "--photometry";
    const uint32_t n[2] = {ask->bins.n[0], ask->bins.n[1]};
    if (detector->type != RMAP_DETECTOR_INTENSITY || ask->bins.quantity != RMAP_PER_SOLID_ANGLE)
        return rmap_error_set(
            err, RMAP_USAGE, "%s has intensities: '%.60s' is %s", what, detector->name,
            detector->type == RMAP_DETECTOR_INTENSITY ? "asked for another quantity"
                                                      : "no intensity grid (type: intensity)");
    if (file && scene->flux_unit != RMAP_FLUX_LM)
        return rmap_error_set(err, RMAP_INPUT,
                              "a lamp maker's file has candelas, and the sources are in %s: give "
                              "their flux in lm, and trace anew",
                              rmap_flux_unit_name(scene));
    if (n[0] > RMAP_LAMP_STEPS_MAX || n[1] > RMAP_LAMP_STEPS_MAX)
        return rmap_error_set(
            err, RMAP_USAGE,
            "%u x %u cells: %s has at most %d steps of gamma and planes C: --cells 90x72", n[0],
            n[1], what, RMAP_LAMP_STEPS_MAX);
    ask->bins.stored = false;
    rmap_far_field_cells(n, ask->bins.n);
    return RMAP_OK;
}

enum rmap_status rmap_detector_request_ask(const struct rmap_context *context,
                                           const struct rmap_detector_request *request,
                                           const struct rmap_map *map,
                                           const struct rmap_overlay *overlay,
                                           struct rmap_detector_ask *ask, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    *ask =
        (struct rmap_detector_ask){.map = map,
                                   .overlay = overlay,
                                   .channels = request->channels,
                                   .centre = request->spot,
                                   .colour = request->figure.true_colour && request->n_output > 0};
    RMAP_TRY(rmap_ask_luminous(rmap_map_scene(map), request->bins.quantity, &ask->luminous, err));
    RMAP_TRY(rmap_find_detector(scene, request->detector, &ask->detector, err));
    RMAP_TRY(rmap_detector_bins_read(scene, ask->detector, &request->bins, &ask->bins, err));
    RMAP_TRY(ask_weighed(&scene->detector[ask->detector], request, ask, err));
    RMAP_TRY(ask_xyz(rmap_map_scene(map), &scene->detector[ask->detector], request, ask, err));
    if ((request->grid || request->table) && (ask->bins.directions || ask->bins.camera))
        return rmap_error_set(err, RMAP_USAGE,
                              "%s: of directions; a table of values is of the area of a plane",
                              request->table ? "--table" : "--cells en12464");
    if (request->grid)
        rmap_lux_grid_bins(&ask->bins);
    if (request->table && (uint64_t)ask->bins.n[0] * ask->bins.n[1] > TABLE_MOST)
        return rmap_error_set(err, RMAP_USAGE,
                              "--table: %u x %u values, and %d are the most: --cells en12464, or "
                              "fewer",
                              ask->bins.n[0], ask->bins.n[1], TABLE_MOST);
    if (request->lamp_file || request->photometry)
        RMAP_TRY(ask_far_field(scene, request->lamp_file, ask, err));
    if (request->world && ask->bins.directions)
        return rmap_error_set(err, RMAP_USAGE,
                              "--frame world: cells over directions have no place in the world");
    if (request->plot_path && !request->spot && !ask->bins.directions)
        return rmap_error_set(err, RMAP_USAGE,
                              "--plot shows the curves of --spot or --mtf: give one; or "
                              "directions: --over direction");
    if (request->plot_path && !request->spot && rmap_output_is(request->plot_path, ".csv"))
        return rmap_error_set(err, RMAP_USAGE,
                              "the polar diagram is a picture: --plot OUT.svg or OUT.png; -o "
                              "OUT.csv has the numbers");
    const enum rmap_flux_unit flux =
        rmap_detector_ask_lumens(ask) ? RMAP_FLUX_LM : rmap_map_scene(ask->map)->flux_unit;
    RMAP_TRY(rmap_image_unit_find(ask->bins.quantity, flux, request->unit, &ask->unit, err));
    if (request->daylight)
        ask->unit = &request->percent;
    const struct rmap_channels *channels = &rmap_map_scene(map)->channels;
    if (context->rank == 0 && ask->xyz && channels->mode == RMAP_COLOUR_SPECTRAL &&
        (channels->n == 2 || channels->n == 3) && scene->flux_unit != RMAP_FLUX_LM)
        fprintf(stderr, "raymap: %d wavelengths do not carry V(lambda): XYZ are of these lines\n",
                channels->n);
    if (context->rank == 0 && request->bins.quantity && scene->flux_unit == RMAP_FLUX_W &&
        strcmp(request->bins.quantity, "luminance") == 0)
        fputs("raymap: --quantity luminance: the sources are in W: this is the radiance\n", stderr);
    if (request->spot &&
        (scene->detector[ask->detector].type != RMAP_DETECTOR_PLANE || ask->bins.camera))
        st = rmap_error_set(err, RMAP_USAGE, "'%s' is %s: a spot lies on a plane",
                            request->detector, ask->bins.camera ? "a camera" : "an intensity grid");
    if (request->tally && ask->bins.camera)
        st = rmap_error_set(err, RMAP_USAGE,
                            "--tally: the picture of a camera is of rays: leave it out");
out:
    return st;
}
