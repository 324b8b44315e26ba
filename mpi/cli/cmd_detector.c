/* SPDX-License-Identifier: MIT
 *
 * raymap detector: a detector's image and its sums, of all rays or of those that match.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/detector/detector_image.h"
#include "analysis/detector/lux_table.h"
#include "analysis/detector/spot.h"
#include "analysis/paths/path_text.h"
#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/map/map_json.h"
#include "mpi/answer/detector_out.h"
#include "mpi/answer/detector_request.h"
#include "mpi/answer/detector_spot.h"
#include "mpi/answer/lamp_sheet_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/dim.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/command/until.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/image_scan.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'hit(lens.*, reflect) >= 2'"},
    RMAP_ASKED_WHICH_OPTION,
    RMAP_UNTIL_OPTION,
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    {"cells", 0, "NXxNY",
     "other cells than the detector's own, as 400x300 or 500; auto: fewer, so that those with "
     "light hold about 25 registrations; en12464: the grid of that standard",
     .words = "auto en12464"},
    {"region", 0, "X0,Y0,X1,Y1",
     "a part of it, as -1,-1,1,1 mm; over directions theta and phi, as 0,0,30,360"},
    {"rotate", 0, "DEG", "turn the cells counterclockwise about the detector's centre"},
    {"quantity", 0, "Q",
     "irradiance, intensity, radiance (or luminance ...), flux, spectral, daylight_factor",
     .words = "irradiance illuminance intensity radiance luminance flux spectral daylight_factor"},
    {"unit", 0, "U", "of the values, as mW/cm2, klx, fc, mcd"},
    {"frame", 0, "WHERE", "of coordinates: detector (default), or world",
     .words = "detector world"},
    {"over", 0, "WHAT", "cells over the area or over the direction of the light",
     .words = "area direction"},
    {"xyz", 0, NULL,
     "the light's colour: CIE XYZ, chromaticity, colour temperature, Duv, CRI; of each cell in -o "
     "OUT.csv, .h5, .npz"},
    {"spot", 0, NULL, "centroid, RMS radius and encircled energy of the light on a plane"},
    {"mtf", 0, NULL, "and the MTF of that spot, by transforming the stored positions"},
    {"frequency", 0, "F", "the highest of the MTF, in cycles per unit of length of the scene",
     "mtf"},
    {"plot", 0, "OUT",
     "the curves of --spot and --mtf: OUT.png, .svg or .csv; of directions the polar diagram: "
     "OUT.png or .svg"},
    {"tally", 0, NULL, "take the sums kept while tracing: at once, errors per registration"},
    {"by", 0, "source", "registrations and flux of each source", .words = "source"},
    RMAP_DIM_OPTIONS,
    {"photometry", 0, NULL,
     "of an intensity grid: intensities at exact C-planes and gammas, cd/klm, beam and field "
     "angle"},
    RMAP_LAMP_SHEET_OPTIONS("photometry"),
    {"table", 0, NULL,
     "the values as a table, as lighting programs print them: also in JSON, and in OUT.csv"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.png or .svg: a picture; .csv, .h5, .npy, .npz: numbers; .exr: linear colour; .ies, .ldt: "
     "a lamp maker's file of an intensity grid; again for more"},
    {"color", 0, "MODE", "false: a scale of the values (default); true: the light's own colour",
     "output", .words = "false true"},
    {"white", 0, "V", "in true colour the value that is shown as white, in the unit of the values",
     "color"},
    {"log", 0, NULL, "logarithmic scale in the picture (default: as its values are spread)",
     "output"},
    {"linear", 0, NULL, "linear scale in the picture", "output"},
    {"isolines", 0, NULL, "lines of equal value in the picture", "output"},
    {"levels", 0, "LIST", "at these values, as 100,200,300,500 (default: round ones)", "isolines"},
    {"values", 0, NULL, "each cell's value in the picture", "output"},
    {"force", 'f', NULL, "replace OUT", "output plot"},
    {NULL}};

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

static void tell_sparse(const struct rmap_context *context,
                        const struct rmap_detector_request *request, const struct answer *answer)
{
    if (request->n_output > 0 && !context->quiet && answer->crowd > 0.0 &&
        answer->crowd < REGISTRATIONS_FEW)
        fprintf(stderr,
                "raymap: a cell with light has %.2g registrations or so: the picture is noise; "
                "--cells auto joins cells\n",
                answer->crowd);
}

/* Of a part that is turned; rmap_free, NULL when memory is short. */
static char *turned_part(const struct rmap_detector_bins *bins, const char *name)
{
    double at[8];
    for (int i = 0; i < 4; i++) {
        const double u = i == 0 || i == 3 ? bins->low[0] : bins->high[0];
        const double v = i < 2 ? bins->low[1] : bins->high[1];
        at[2 * i] = u * bins->cosine - v * bins->sine;
        at[2 * i + 1] = u * bins->sine + v * bins->cosine;
    }
    return rmap_path_format(
        "registered(%s, polygon(%.12g, %.12g, %.12g, %.12g, %.12g, %.12g, %.12g, "
        "%.12g))",
        name, at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7]);
}

/* Of directions: phi is told from 0 to 360 degrees, as criteria have it. */
static char *angles_part(const struct rmap_detector_bins *bins, const char *name)
{
    const double degree = 180.0 / RMAP_PI, least = bins->low[0] * degree,
                 most = bins->high[0] * degree, across = (bins->high[1] - bins->low[1]) * degree;
    const double turned = (bins->low[1] + bins->rotate_rad) * degree;
    const double tiny = 1e-9; /* of the way to radians and back */
    const double from = across < 360.0 - tiny ? turned - 360.0 * floor(turned / 360.0) : 0.0;
    if (from + across < 360.0 + tiny)
        return rmap_path_format("registered(%s, rect(%.12g, %.12g, %.12g, %.12g))", name, least,
                                from, most, from + across);
    return rmap_path_format("registered(%s, rect(%.12g, %.12g, %.12g, 360)) or "
                            "registered(%s, rect(%.12g, 0, %.12g, %.12g))",
                            name, least, from, most, name, least, most, from + across - 360.0);
}

/* What is registered in the image's part of the detector, as a criterion, beside that part. Of
 * directions on a plane there is none. */
static enum rmap_status put_criterion(const struct rmap_detector_image *image, json_t *document,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_bins *bins = &image->bins;
    json_t *region = json_object_get(document, "region");
    char *name = NULL, *criterion = NULL;
    if (!region || bins->directions != (image->detector->type == RMAP_DETECTOR_INTENSITY))
        return RMAP_OK;
    RMAP_TRY(rmap_path_quote(image->detector->name, &name, err));
    criterion = bins->directions ? angles_part(bins, name)
                : bins->rotate_rad != 0.0
                    ? turned_part(bins, name)
                    : rmap_path_format("registered(%s, rect(%.12g, %.12g, %.12g, %.12g))", name,
                                       bins->low[0], bins->low[1], bins->high[0], bins->high[1]);
    (void)json_object_set_new(region, "criterion", json_string(criterion ? criterion : ""));
out:
    rmap_free(name);
    rmap_free(criterion);
    return st;
}

static enum rmap_status show(const struct rmap_context *context,
                             const struct rmap_detector_request *request,
                             const struct rmap_map *map, const struct answer *answer,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_image *image = answer->image;
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(request->table && rmap_output_is(request->output[i], ".csv")
                     ? rmap_lux_table_write(image, request->where, request->output[i], err)
                     : rmap_detector_write(image, &request->figure, request->output[i], err));
    if (request->plot_path && !answer->spot)
        RMAP_TRY(rmap_polar_write(image, request->where, request->plot_path, err));
    if (request->plot_path && answer->spot)
        RMAP_TRY(rmap_spot_write(answer->spot, image->detector->name, request->where,
                                 request->plot_path, err));
    if (context->json) {
        json_t *document = rmap_detector_image_json(image, request->where);
        RMAP_TRY(put_criterion(image, document, err));
        if (document && answer->spot)
            rmap_spot_json(answer->spot, document);
        if (document && request->table)
            rmap_lux_table_json(image, document);
        if (document && request->photometry && image->registrations > 0.0)
            RMAP_TRY(rmap_photometry_out(image, &request->sheet, document, err));
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
    if (request->table)
        RMAP_TRY(rmap_lux_table_print(image, stdout, err));
    if (request->photometry && image->registrations > 0.0)
        RMAP_TRY(rmap_photometry_out(image, &request->sheet, NULL, err));
    if (answer->spot)
        rmap_spot_print(answer->spot, stdout);
out:
    return st;
}

/* Which rays and registrations of the detector asked about. */
static enum rmap_status select(const struct rmap_context *context,
                               const struct rmap_arguments *given,
                               struct rmap_detector_request *request,
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
static enum rmap_status sum_up(const struct rmap_context *context,
                               const struct rmap_detector_request *request,
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
static enum rmap_status sum_cells(const struct rmap_context *context,
                                  const struct rmap_detector_request *request,
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
static enum rmap_status find_image(const struct rmap_context *context,
                                   struct rmap_detector_request *request,
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
    struct rmap_detector_request request;
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct selected selected = {.criterion = NULL};
    struct rmap_detector_ask ask;
    struct answer answer = {0};
    enum rmap_status st = rmap_detector_request_read(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &selected.asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    st = rmap_dim_read(given, map, err);
    if (st == RMAP_OK && request.daylight)
        st = rmap_detector_request_daylight(map, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_detector_request_ask(context, &request, map, overlay, &ask, err);
    if (st == RMAP_OK)
        st = select(context, given, &request, &ask, &selected, err);
    const struct rmap_choice choice = {selected.criterion, selected.which};
    if (st == RMAP_OK)
        st = rmap_until_begin(&request.until, map,
                              selected.criterion && rmap_criterion_of_ids(selected.criterion), err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(find_image(context, &request, map, &ask, &choice, &answer, err));
    if (answer.image) {
        answer.image->which = selected.which;
        answer.image->part = &request.until.part;
        answer.image->world = request.world;
    }
    if (request.spot)
        RMAP_TRY(rmap_detector_spot_find(context, &request, &ask, &choice, answer.image,
                                         &answer.spot, err));
    if (context->rank == 0) {
        rmap_tell_hint(context, map, &choice, answer.image->registrations > 0);
        st = show(context, &request, map, &answer, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_detector_request_fini(&request);
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
