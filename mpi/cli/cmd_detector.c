/* SPDX-License-Identifier: MIT
 *
 * raymap detector: a detector's image and its sums, of all rays or of those that match.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/registration_response.h"
#include "analysis/detector/detector_image.h"
#include "analysis/detector/far_field.h"
#include "analysis/detector/spot.h"
#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/map/map_json.h"
#include "mpi/answer/detector_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/luminous.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/command/until.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"
#include "mpi/scan/image_scan.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'hit(lens.*, reflect) >= 2'"},
    RMAP_ASKED_WHICH_OPTION,
    RMAP_UNTIL_OPTION,
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    {"cells", 0, "NXxNY",
     "other cells than the detector's own, as 400x300 or 500; auto: fewer, so that those with "
     "light hold about 25 registrations",
     .words = "auto"},
    {"region", 0, "X0,Y0,X1,Y1",
     "a part of it, as -1,-1,1,1 mm; over directions theta and phi, as 0,0,30,360"},
    {"rotate", 0, "DEG", "turn the cells counterclockwise about the detector's centre"},
    {"quantity", 0, "Q", "irradiance, intensity, radiance (or luminance ...), flux, spectral",
     .words = "irradiance illuminance intensity radiance luminance flux spectral"},
    {"unit", 0, "U", "of the values, as mW/cm2, klx, fc, mcd"},
    {"frame", 0, "WHERE", "of coordinates: detector (default), or world",
     .words = "detector world"},
    {"over", 0, "WHAT", "cells over the area or over the direction of the light",
     .words = "area direction"},
    {"spot", 0, NULL, "centroid, RMS radius and encircled energy of the light on a plane"},
    {"mtf", 0, NULL, "and the MTF of that spot, by transforming the stored positions"},
    {"frequency", 0, "F", "the highest of the MTF, in cycles per unit of length of the scene",
     "mtf"},
    {"plot", 0, "OUT",
     "the curves of --spot and --mtf: OUT.png, .svg or .csv; of directions the polar diagram: "
     "OUT.png or .svg"},
    {"tally", 0, NULL, "take the sums kept while tracing: at once, errors per registration"},
    {"by", 0, "source", "registrations and flux of each source", .words = "source"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.png or .svg: a picture; .csv, .h5, .npy, .npz: numbers; .exr: linear colour; .ies, .ldt: "
     "a lamp maker's file of an intensity grid; again for more"},
    {"color", 0, "MODE", "false: a scale of the values (default); true: the light's own colour",
     "output", .words = "false true"},
    {"log", 0, NULL, "logarithmic scale in the picture (default: as its values are spread)",
     "output"},
    {"linear", 0, NULL, "linear scale in the picture", "output"},
    {"isolines", 0, NULL, "lines of equal value in the picture", "output"},
    {"values", 0, NULL, "each cell's value in the picture", "output"},
    {"force", 'f', NULL, "replace OUT", "output plot"},
    {NULL}};

struct request {
    const char *map_path, *detector, *where, *unit;
    char **output; /* [n_output] */
    size_t n_output;
    struct rmap_detector_bins_asked bins;
    bool tally, channels, force, by_source, world, auto_cells, lamp_file;
    bool spot, mtf;
    struct rmap_until until;
    double frequency;      /* 0: by the size of the spot */
    const char *plot_path; /* of the curves */
    struct rmap_figure_detector figure;
};

static enum rmap_status read_bins(const struct rmap_arguments *given, struct request *request,
                                  struct rmap_error *err)
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
    request->auto_cells = cells && strcmp(cells, "auto") == 0;
    if (cells && !request->auto_cells)
        RMAP_TRY(rmap_read_cells(cells, ", or auto", bins->cells, err));
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
         bins->quantity || bins->over || rmap_argument(given, "receivers")))
        st = rmap_error_set(err, RMAP_USAGE,
                            "--tally has the detector's own cells and all rays: it goes with none "
                            "of --where, --which, --receivers, --cells, --region, --rotate, "
                            "--quantity and --over");
out:
    return st;
}

static enum rmap_status read_spot(const struct rmap_arguments *given, struct request *request,
                                  struct rmap_error *err)
{
    static const char *const suffixes[] = {".png", ".svg", ".csv", NULL};
    const char *frequency = rmap_argument(given, "frequency");
    request->mtf = rmap_argument(given, "mtf") != NULL || frequency;
    request->spot = rmap_argument(given, "spot") != NULL || request->mtf;
    request->plot_path = rmap_argument(given, "plot");
    if (frequency) {
        char *end = NULL;
        request->frequency = strtod(frequency, &end);
        if (end == frequency || *end || !(request->frequency > 0.0) ||
            !isfinite(request->frequency))
            return rmap_error_set(err, RMAP_USAGE,
                                  "--frequency '%.40s' is no number of cycles per unit of length "
                                  "greater than 0",
                                  frequency);
    }
    if (request->spot && request->tally)
        return rmap_error_set(err, RMAP_USAGE, "--tally knows no places: leave it out for --spot");
    if (!request->plot_path)
        return RMAP_OK;
    return rmap_output_check(request->plot_path, suffixes, request->force, err);
}

/* Their cells are centred on the angles of the file. */
static enum rmap_status read_lamp_files(const struct rmap_arguments *given, struct request *request,
                                        struct rmap_error *err)
{
    static const char *const other[] = {"tally", "region", "over", "unit"};
    size_t n = 0;
    for (size_t i = 0; i < request->n_output; i++)
        n += rmap_detector_is_lamp_file(request->output[i]);
    request->lamp_file = n > 0;
    if (n == 0)
        return RMAP_OK;
    if (n < request->n_output || request->plot_path)
        return rmap_error_set(err, RMAP_USAGE,
                              "a lamp maker's file has cells of its own, about its angles: write "
                              "pictures and numbers by another command");
    for (size_t i = 0; i < sizeof other / sizeof *other; i++)
        if (rmap_argument(given, other[i]))
            return rmap_error_set(err, RMAP_USAGE,
                                  "a lamp maker's file is of all directions, in cd: leave --%s out",
                                  other[i]);
    return request->auto_cells
               ? rmap_error_set(err, RMAP_USAGE,
                                "--cells auto: of a lamp maker's file say how many steps of gamma "
                                "and planes C, as --cells 36x24")
               : RMAP_OK;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    const char *color = rmap_argument(given, "color"), *by = rmap_argument(given, "by");
    const char *frame = rmap_argument(given, "frame");
    *request = (struct request){
        .map_path = given->operand[0],
        .detector = given->operand[1],
        .where = rmap_argument(given, "where"),
        .unit = rmap_argument(given, "unit"),
        .tally = rmap_argument(given, "tally") != NULL,
        .force = rmap_argument(given, "force") != NULL,
        .by_source = by != NULL,
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
    enum rmap_status st = read_bins(given, request, err);
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
    return st;
}

/* What light is asked about. */
struct selected {
    struct rmap_asked asked;
    struct rmap_criterion *criterion; /* NULL: all rays */
    struct rmap_which *which;
};

/* In a cell, of --cells auto: errors of a fifth. Below the few, a picture shows noise. */
static const double REGISTRATIONS_WANTED = 25.0, REGISTRATIONS_FEW = 4.0;

/* What was found; on rank 0. */
struct answer {
    struct rmap_detector_image *image;
    struct rmap_spot *spot; /* or NULL */
    double crowd;           /* registrations in a cell with light */
};

static void tell_sparse(const struct rmap_context *context, const struct request *request,
                        const struct answer *answer)
{
    if (request->n_output > 0 && !context->quiet && answer->crowd > 0.0 &&
        answer->crowd < REGISTRATIONS_FEW)
        fprintf(stderr,
                "raymap: a cell with light has %.2g registrations or so: the picture is noise; "
                "--cells auto joins cells\n",
                answer->crowd);
}

static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct rmap_map *map, const struct answer *answer,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_image *image = answer->image;
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_detector_write(image, &request->figure, request->output[i], err));
    if (request->plot_path && !answer->spot)
        RMAP_TRY(rmap_polar_write(image, request->where, request->plot_path, err));
    if (request->plot_path && answer->spot)
        RMAP_TRY(rmap_spot_write(answer->spot, image->detector->name, request->where,
                                 request->plot_path, err));
    if (context->json) {
        json_t *document = rmap_detector_image_json(image, request->where);
        if (document && answer->spot)
            rmap_spot_json(answer->spot, document);
        rmap_json_add_part(document, image->part);
        return rmap_json_print(rmap_json_of_map(document, map), stdout, err);
    }
    char part[RMAP_MAP_PART_LEN];
    rmap_detector_image_print(image, request->where, stdout);
    rmap_map_part_text(image->part, part);
    if (part[0])
        printf("%-14s %s\n", "until", part);
    tell_sparse(context, request, answer);
    if (request->by_source)
        RMAP_TRY(rmap_detector_image_print_sources(image, stdout, err));
    if (answer->spot)
        rmap_spot_print(answer->spot, stdout);
out:
    return st;
}

enum { FREQUENCIES = 51, FINER = 8 };

/* A round number. */
static double round_above(double x)
{
    const double below = rmap_round_below(x);
    return x > 1.5 * below ? 2.0 * below : below;
}

/* Collective. A pass over the registrations; the spot on rank 0. */
static enum rmap_status sum_spot(const struct rmap_context *context, struct rmap_spot_ask *ask,
                                 const struct rmap_choice *choice, struct rmap_spot **spot,
                                 struct rmap_error *err)
{
    const struct rmap_fold fold = {.kind = &rmap_spot_sums_kind,
                                   .context = ask,
                                   .map = ask->map,
                                   .criterion = choice->criterion,
                                   .which = choice->which,
                                   .columns = rmap_spot_sums_columns(ask),
                                   .only_detector = 1 + ask->detector,
                                   .overlay = ask->overlay};
    void *state = NULL;
    enum rmap_status st = rmap_fold_run(context, &fold, &state, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_spot_create(state, spot, err);
    fold.kind->destroy(state);
    return rmap_agree(context, st, err);
}

/* Frequencies beyond it are finer than the places that are stored. */
static double finest(const struct rmap_detector *detector)
{
    return 0.25 * 65535.0 / fmax(detector->size[0], detector->size[1]);
}

/* A little stray light far out makes the RMS size many times that of the spot, and frequencies
 * that suit it show nothing: whether the contrast is still high at all of them, in one of the
 * directions, and there are others. */
static bool wants_finer(const struct rmap_spot *spot, const struct rmap_detector *detector)
{
    const size_t n = spot->n_frequency;
    const double next = FINER * spot->frequency_step * (double)(n - 1);
    double least[2] = {1.0, 1.0};
    for (size_t k = 0; k < 2 * n; k++)
        least[k / n] = fmin(least[k / n], spot->mtf[k].value);
    return fmax(least[0], least[1]) > 0.5 && next < finest(detector);
}

/* Collective. The lowest frequencies with a contrast of one half are those of the first passes that
 * have them, whatever frequencies are asked for: a curve of few points would pass them over. */
static enum rmap_status find_half(const struct rmap_context *context, struct rmap_spot_ask *ask,
                                  const struct rmap_choice *choice, bool may_go_on,
                                  struct rmap_spot **spot, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_estimate half[2] = {{(double)NAN, (double)NAN}, {(double)NAN, (double)NAN}};
    int finer = 0;
    do {
        rmap_spot_destroy(*spot);
        *spot = NULL;
        RMAP_TRY(sum_spot(context, ask, choice, spot, err));
        for (int d = 0; d < 2 && *spot; d++) {
            if (isnan(half[d].value))
                half[d] = (*spot)->half[d];
            (*spot)->half[d] = half[d];
        }
        finer =
            *spot && may_go_on &&
            wants_finer(*spot, &rmap_scene_with(ask->map, ask->overlay)->detector[ask->detector]);
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&finer, 1, MPI_INT, 0, context->comm)));
        ask->frequency_step *= FINER;
    } while (finer);
out:
    return st;
}

/* Collective. More passes over the registrations, about the centre that the image found. */
static enum rmap_status find_spot(const struct rmap_context *context, const struct request *request,
                                  const struct rmap_detector_ask *image_ask,
                                  const struct rmap_choice *choice, struct answer *answer,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_spot_ask ask = {.map = image_ask->map,
                                .overlay = image_ask->overlay,
                                .detector = image_ask->detector,
                                .bins = image_ask->bins,
                                .n_frequency = request->mtf ? FREQUENCIES : 0,
                                .tangential_rad = 0.5 * RMAP_PI};
    double first[4] = {0.0, 0.0, 0.0, 0.0};
    struct rmap_spot *own = NULL;
    if (context->rank == 0 && isfinite(answer->image->rms_radius)) {
        const double *centre = answer->image->centroid, rms = answer->image->rms_radius;
        first[0] = centre[0];
        first[1] = centre[1];
        first[2] = hypot(centre[0], centre[1]) > rms ? atan2(centre[1], centre[0]) : 0.5 * RMAP_PI;
        if (rms > 0.0) /* a Gaussian's MTF is 0.007 there */
            first[3] = fmin(round_above(0.5 * sqrt(2.0) / rms), finest(answer->image->detector));
    }
    RMAP_TRY(RMAP_MPI(MPI_Bcast(first, 4, MPI_DOUBLE, 0, context->comm)));
    ask.centre[0] = first[0];
    ask.centre[1] = first[1];
    ask.tangential_rad =
        isnan(request->bins.rotate_deg) ? first[2] : ask.bins.rotate_rad + 0.5 * RMAP_PI;
    ask.frequency_step = (first[3] > 0.0 ? first[3] : 1.0) / (FREQUENCIES - 1);
    RMAP_TRY(find_half(context, &ask, choice, request->mtf && first[3] > 0.0, &answer->spot, err));
    if (request->frequency > 0.0) {
        ask.frequency_step = request->frequency / (FREQUENCIES - 1);
        RMAP_TRY(sum_spot(context, &ask, choice, &own, err));
    }
    for (int d = 0; d < 2 && own; d++)
        own->half[d] = answer->spot->half[d];
    if (own) {
        rmap_spot_destroy(answer->spot);
        answer->spot = own;
    }
    if (answer->spot)
        answer->spot->which = choice->which;
out:
    return st;
}

/* What the detector's response makes of it. */
static enum rmap_status ask_weighed(const struct rmap_detector *detector,
                                    const struct request *request, struct rmap_detector_ask *ask,
                                    struct rmap_error *err)
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

/* For a lamp maker's file. */
static enum rmap_status ask_far_field(const struct rmap_scene *scene, struct rmap_detector_ask *ask,
                                      struct rmap_error *err)
{
    const struct rmap_detector *detector = &scene->detector[ask->detector];
    const uint32_t n[2] = {ask->bins.n[0], ask->bins.n[1]};
    if (detector->type != RMAP_DETECTOR_INTENSITY || ask->bins.quantity != RMAP_PER_SOLID_ANGLE)
        return rmap_error_set(
            err, RMAP_USAGE, "a lamp maker's file has intensities: '%.60s' is %s", detector->name,
            detector->type == RMAP_DETECTOR_INTENSITY ? "asked for another quantity"
                                                      : "no intensity grid (type: intensity)");
    if (scene->flux_unit != RMAP_FLUX_LM)
        return rmap_error_set(err, RMAP_INPUT,
                              "a lamp maker's file has candelas, and the sources are in W: give "
                              "their flux in lm, and trace anew");
    if (n[0] > RMAP_LAMP_STEPS_MAX || n[1] > RMAP_LAMP_STEPS_MAX)
        return rmap_error_set(
            err, RMAP_USAGE,
            "%u x %u cells: a lamp maker's file has at most %d steps of gamma and "
            "planes C: --cells 90x72",
            n[0], n[1], RMAP_LAMP_STEPS_MAX);
    ask->bins.stored = false;
    rmap_far_field_cells(n, ask->bins.n);
    return RMAP_OK;
}

/* What is to be summed. */
static enum rmap_status choose(const struct rmap_context *context, const struct request *request,
                               const struct rmap_map *map, const struct rmap_overlay *overlay,
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
    if (request->lamp_file)
        RMAP_TRY(ask_far_field(scene, ask, err));
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
    RMAP_TRY(rmap_image_unit_find(ask->bins.quantity, rmap_detector_ask_lumens(ask), request->unit,
                                  &ask->unit, err));
    if (context->rank == 0 && request->bins.quantity && scene->flux_unit == RMAP_FLUX_W &&
        strcmp(request->bins.quantity, "luminance") == 0)
        fputs("raymap: --quantity luminance: the sources are in W: this is the radiance\n", stderr);
    if (request->spot && scene->detector[ask->detector].type != RMAP_DETECTOR_PLANE)
        st = rmap_error_set(err, RMAP_USAGE, "'%s' is an intensity grid: a spot lies on a plane",
                            request->detector);
out:
    return st;
}

/* Which rays and registrations of the detector asked about. */
static enum rmap_status select(const struct rmap_context *context,
                               const struct rmap_arguments *given, struct request *request,
                               const struct rmap_detector_ask *ask, struct selected *selected,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_scene_with(ask->map, ask->overlay);
    const struct rmap_index_set detector = {.low = ask->detector, .span = 1};
    if (selected->asked.n > 0)
        RMAP_TRY(
            rmap_asked_compile(context, &selected->asked, 0, scene, &selected->criterion, err));
    if (selected->criterion)
        request->figure.criterion = request->where = rmap_criterion_text(selected->criterion);
    RMAP_TRY(rmap_asked_which(context, given, &selected->asked, scene, &detector,
                              selected->criterion, &selected->which, err));
    rmap_asked_tell_picked(context, ask->map, selected->which, request->detector);
out:
    return st;
}

/* Collective. */
static enum rmap_status sum_up(const struct rmap_context *context, const struct request *request,
                               const struct rmap_map *map, const struct rmap_detector_ask *ask,
                               const struct rmap_choice *choice, struct rmap_detector_sums *sums,
                               struct rmap_error *err)
{
    enum rmap_status st = rmap_detector_sums_init_as(sums, ask, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (request->tally && !ask->colour)
        rmap_detector_sums_add_tally(sums, rmap_map_tally(map));
    else
        st = rmap_image_scan(context, map, choice, sums, err);
out:
    return st;
}

/* Collective. The cells to ask for in place of those in which the sums, of rank 0, were taken. */
static enum rmap_status take_fewer(const struct rmap_context *context,
                                   const struct rmap_detector_sums *sums,
                                   struct rmap_detector_ask *ask, bool *are_fewer_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double crowd = rmap_detector_sums_crowd(sums);
    const double joined =
        crowd > 0.0 && crowd < REGISTRATIONS_WANTED ? sqrt(REGISTRATIONS_WANTED / crowd) : 1.0;
    uint32_t n[2];
    for (int k = 0; k < 2; k++)
        n[k] = (uint32_t)fmax(floor(ask->bins.n[k] / joined), 1.0);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(n, 2, MPI_UINT32_T, 0, context->comm)));
    *are_fewer_ret = n[0] < ask->bins.n[0] || n[1] < ask->bins.n[1];
    memcpy(ask->bins.n, n, sizeof n);
    ask->bins.stored = ask->bins.stored && !*are_fewer_ret;
out:
    return st;
}

/* Collective. In the cells asked for, or in fewer. */
static enum rmap_status sum_cells(const struct rmap_context *context, const struct request *request,
                                  const struct rmap_map *map, struct rmap_detector_ask *ask,
                                  const struct rmap_choice *choice, struct rmap_detector_sums *sums,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool are_fewer = false;
    RMAP_TRY(sum_up(context, request, map, ask, choice, sums, err));
    if (request->auto_cells)
        RMAP_TRY(take_fewer(context, sums, ask, &are_fewer, err));
    if (are_fewer) {
        rmap_detector_sums_fini(sums);
        RMAP_TRY(sum_up(context, request, map, ask, choice, sums, err));
    }
out:
    return st;
}

/* Collective. Of so much of the map that the flux is known well enough; the image is rank 0's. */
static enum rmap_status find_image(const struct rmap_context *context, struct request *request,
                                   const struct rmap_map *map, struct rmap_detector_ask *ask,
                                   const struct rmap_choice *choice, struct answer *answer,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_ask asked = *ask;
    struct rmap_detector_sums sums = {0};
    int is_exact = 0;
    do {
        rmap_detector_sums_fini(&sums);
        rmap_detector_image_destroy(answer->image);
        answer->image = NULL;
        *ask = asked;
        RMAP_TRY(sum_cells(context, request, map, ask, choice, &sums, err));
        if (context->rank == 0)
            st = rmap_detector_image_create(map, &sums, &answer->image, err);
        RMAP_TRY(rmap_agree(context, st, err));
        is_exact = context->rank == 0 && rmap_until_suffices(&request->until, answer->image->flux,
                                                             answer->image->flux_error);
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&is_exact, 1, MPI_INT, 0, context->comm)));
    } while (rmap_until_goes_on(&request->until, is_exact));
    answer->crowd = rmap_detector_sums_crowd(&sums);
    if (context->rank == 0)
        st = rmap_detector_image_find_uniformity(answer->image, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_detector_sums_fini(&sums);
    return st;
}

static enum rmap_status run_detector(const struct rmap_context *context,
                                     const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct selected selected = {.criterion = NULL};
    struct rmap_detector_ask ask;
    struct answer answer = {0};
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &selected.asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    st = choose(context, &request, map, overlay, &ask, err);
    if (st == RMAP_OK)
        st = select(context, given, &request, &ask, &selected, err);
    const struct rmap_choice choice = {selected.criterion, selected.which};
    if (st == RMAP_OK)
        st = rmap_until_begin(&request.until, map, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(find_image(context, &request, map, &ask, &choice, &answer, err));
    if (answer.image) {
        answer.image->which = selected.which;
        answer.image->part = &request.until.part;
        answer.image->world = request.world;
    }
    if (request.spot)
        RMAP_TRY(find_spot(context, &request, &ask, &choice, &answer, err));
    if (context->rank == 0) {
        rmap_tell_hint(context, map, &choice, answer.image->registrations > 0);
        st = show(context, &request, map, &answer, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_until_fini(&request.until);
    rmap_free(request.output);
    rmap_spot_destroy(answer.spot);
    rmap_detector_image_destroy(answer.image);
    rmap_which_destroy(selected.which);
    rmap_criterion_destroy(selected.criterion);
    rmap_asked_fini(&selected.asked);
    rmap_overlay_destroy(overlay);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_detector = {
    .name = "detector",
    .summary = "a detector's image: sums, peak, errors, picture",
    .operands = "MAP NAME [--where CRITERION] [--receivers FILE] [-o OUT]",
    .help =
        "Prints what detector NAME caught: flux, mean, peak and where it lies, the least cell,\n"
        "percentiles and uniformities, with standard errors; with --where, of the matching rays "
        "alone, as\n\n"
        "  raymap detector lens.raymap sensor --where 'hit(*, reflect) >= 2' -o part.png\n\n"
        "Values are in W/m2 or lx for a plane, W/sr or cd for an intensity grid; --quantity\n"
        "and --over choose others, --cells, --region and --rotate other cells. FILE lists\n"
        "receivers that the scene did not have, with the keys of `detectors:` in a scene file:\n"
        "NAME may be one of them, and criteria may speak of them.",
    .options = options,
    .min_operands = 2,
    .max_operands = 2,
    .run = run_detector,
};
