/* SPDX-License-Identifier: MIT
 *
 * raymap detector: a detector's image and its sums, of all rays or of those that match.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "analysis/detector_image.h"
#include "analysis/figure_detector.h"
#include "base/alloc.h"
#include "io/diagnostics.h"
#include "io/raster.h"
#include "mpi/agree.h"
#include "mpi/asked.h"
#include "mpi/image_scan.h"
#include "mpi/json_out.h"
#include "mpi/load.h"
#include "mpi/output.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'hit(lens.*, reflect) >= 2'"},
    RMAP_ASKED_OPTIONS,
    {"output", 'o', "OUT", "OUT.png or OUT.svg: a picture; OUT.csv: the cells' values"},
    {"color", 0, "MODE", "false: a scale of the values (default); true: the light's own colour"},
    {"log", 0, NULL, "logarithmic scale in the picture"},
    {"force", 'f', NULL, "replace OUT"},
    {NULL}};

static const char *const suffixes[] = {".png", ".svg", ".csv", NULL};

struct request {
    const char *map_path, *detector, *where, *output_path;
    struct rmap_figure_detector figure;
};

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    const char *color = rmap_argument(given, "color");
    *request = (struct request){
        .map_path = given->operand[0],
        .detector = given->operand[1],
        .where = rmap_argument(given, "where"),
        .output_path = rmap_argument(given, "output"),
    };
    request->figure = (struct rmap_figure_detector){
        .criterion = request->where,
        .true_colour = color && strcmp(color, "true") == 0,
        .logarithmic = rmap_argument(given, "log") != NULL,
    };
    if (color && !request->figure.true_colour && strcmp(color, "false") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--color '%s': say false or true", color);
    if (!request->output_path)
        return RMAP_OK;
    return rmap_output_check(request->output_path, suffixes, rmap_argument(given, "force") != NULL,
                             err);
}

static enum rmap_status find_detector(const struct rmap_scene *scene, const char *name,
                                      int32_t *found, struct rmap_error *err)
{
    const char **known = rmap_alloc(scene->n_detector + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the detectors' names");
    enum rmap_status st = RMAP_INPUT;
    for (size_t d = 0; d < scene->n_detector; d++) {
        known[d] = scene->detector[d].name;
        if (strcmp(known[d], name) == 0) {
            *found = (int32_t)d;
            st = RMAP_OK;
        }
    }
    const char *nearest = rmap_nearest_word(name, known, scene->n_detector);
    if (st != RMAP_OK && nearest)
        (void)rmap_error_set(err, st, "no detector named '%s' in this map (did you mean '%s'?)",
                             name, nearest);
    else if (st != RMAP_OK)
        (void)rmap_error_set(err, st, "no detector named '%s' in this map; it has %zu", name,
                             scene->n_detector);
    rmap_free(known);
    return st;
}

static enum rmap_status write_csv(const struct rmap_detector_image *image,
                                  const struct request *request, struct rmap_error *err)
{
    FILE *file = fopen(request->output_path, "w");
    if (!file)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", request->output_path,
                              strerror(errno));
    rmap_detector_image_csv(image, request->where, file);
    int failed = ferror(file);
    if (fclose(file) != 0 || failed)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", request->output_path,
                              strerror(errno));
    return RMAP_OK;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct rmap_map *map, const struct rmap_detector_sums *sums,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_image *image = NULL;
    struct rmap_svg *svg = NULL;
    const char *path = request->output_path;
    RMAP_TRY(rmap_detector_image_create(map, sums, &image, err));
    if (path && rmap_picture_kind(path) != RMAP_PICTURE_NONE) {
        RMAP_TRY(rmap_figure_detector(image, &request->figure, &svg, err));
        RMAP_TRY(rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err));
    } else if (path) {
        RMAP_TRY(write_csv(image, request, err));
    }
    if (context->json)
        st = rmap_json_print(rmap_detector_image_json(image, request->where), stdout, err);
    else
        rmap_detector_image_print(image, request->where, stdout);
out:
    rmap_svg_destroy(svg);
    rmap_detector_image_destroy(image);
    return st;
}

static enum rmap_status run_detector(const struct rmap_context *context,
                                     const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_detector_sums sums = {0};
    int32_t detector = -1;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    const struct rmap_scene *scene = rmap_map_scene(map);
    bool colour = request.figure.true_colour && request.output_path;
    st = find_detector(scene, request.detector, &detector, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, scene, &criterion, err);
    if (criterion)
        request.figure.criterion = request.where = rmap_criterion_text(criterion);
    if (st == RMAP_OK)
        st = rmap_detector_sums_init(&sums, map, detector, colour, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (criterion || colour)
        RMAP_TRY(rmap_image_scan(context, map, criterion, &sums, err));
    else
        rmap_detector_sums_add_tally(&sums, rmap_map_tally(map));
    if (context->rank == 0)
        st = show(context, &request, map, &sums, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_detector_sums_fini(&sums);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_detector = {
    .name = "detector",
    .summary = "a detector's image: sums, peak, errors, picture",
    .operands = "MAP NAME [--where CRITERION] [-o OUT]",
    .help = "Prints what detector NAME caught: flux, mean, peak and where it lies, with standard\n"
            "errors. Without --where this is the image summed up during the trace; with it, of\n"
            "the matching rays alone, as\n\n"
            "  raymap detector lens.raymap sensor --where 'hit(*, reflect) >= 2' -o ghosts.png\n\n"
            "Values are in W/m2 or lx for a plane, W/sr or cd for an intensity grid.",
    .options = options,
    .min_operands = 2,
    .max_operands = 2,
    .run = run_detector,
};
