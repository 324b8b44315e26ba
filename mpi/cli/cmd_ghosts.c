/* SPDX-License-Identifier: MIT
 *
 * raymap ghosts: the ghosts on a detector, by the pair of surfaces that makes each.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/detector_image.h"
#include "base/alloc.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/answer/detector_out.h"
#include "mpi/answer/ghost_list.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/asked.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/image_scan.h"
#include "mpi/trace/scene_as_map.h"

enum { TOP_DEFAULT = 10, RAYS_DEFAULT = 200000, PATH_NBYTES = 4096 };

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'source(sun)'"},
    RMAP_ASKED_OPTIONS,
    RMAP_SCENE_RAYS_OPTION(200000),
    {"cells", 0, "NXxNY", "in which the brightest is sought (default: the detector's own)"},
    {"top", 0, "N", "so many pairs of surfaces (default 10)"},
    {"by", 0, "LEVEL", "whose names count: surface (default), object or group",
     .words = "surface object group"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.csv: the table; OUT.png or .svg: OUT-0 the direct image, OUT-1 the first ghost ..."},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

static const char *const suffixes[] = {".png", ".svg", ".csv", NULL};

struct request {
    const char *map_path, *detector, *where;
    char **output; /* [n_output] */
    size_t n_output;
    uint64_t top;
    struct rmap_detector_bins_asked bins;
    enum rmap_path_level level;
    bool force;
};

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    static const char *const level[] = {"surface", "object", "group"};
    const char *by = rmap_argument(given, "by"), *cells = rmap_argument(given, "cells");
    size_t k = 0;
    *request = (struct request){.map_path = given->operand[0],
                                .detector = given->operand[1],
                                .where = rmap_argument(given, "where"),
                                .force = rmap_argument(given, "force") != NULL,
                                .top = TOP_DEFAULT,
                                .bins = {.rotate_deg = (double)NAN}};
    while (by && k < 3 && strcmp(by, level[k]) != 0)
        k++;
    if (k == 3)
        return rmap_error_set(err, RMAP_USAGE, "--by '%.40s': say surface, object or group", by);
    request->level = (enum rmap_path_level)k;
    enum rmap_status st = rmap_argument_count(given, "top", &request->top, err);
    if (st == RMAP_OK && cells)
        st = rmap_read_cells(cells, "", request->bins.cells, err);
    if (st == RMAP_OK)
        st = rmap_argument_each(given, "output", &request->output, &request->n_output, err);
    for (size_t i = 0; i < request->n_output && st == RMAP_OK; i++)
        st = rmap_output_check(request->output[i], suffixes, request->force, err);
    return st;
}

/* "a.png" becomes "a-3.png". */
static enum rmap_status picture_path(const char *output, size_t row, char path[PATH_NBYTES],
                                     struct rmap_error *err)
{
    const char *dot = strrchr(output, '.');
    const int n = snprintf(path, PATH_NBYTES, "%.*s-%zu%s", (int)(dot - output), output, row, dot);
    return n < PATH_NBYTES ? RMAP_OK
                           : rmap_error_set(err, RMAP_USAGE, "'%.80s...' is too long", output);
}

static enum rmap_status write_picture(const struct request *request,
                                      const struct rmap_detector_image *image,
                                      const struct rmap_ghost *ghost, size_t row,
                                      struct rmap_error *err)
{
    const struct rmap_figure_detector figure = {.criterion = ghost->surfaces ? ghost->surfaces
                                                                             : ghost->criterion,
                                                .scale = RMAP_SCALE_AUTO};
    enum rmap_status st = RMAP_OK;
    char path[PATH_NBYTES];
    for (size_t i = 0; i < request->n_output; i++) {
        if (rmap_output_is(request->output[i], ".csv"))
            continue;
        RMAP_TRY(picture_path(request->output[i], row, path, err));
        RMAP_TRY(rmap_output_check(path, suffixes, request->force, err));
        RMAP_TRY(rmap_detector_write(image, &figure, path, err));
    }
out:
    return st;
}

/* Collective. Image of the registrations that row's criterion chooses, on rank 0 into the row. */
static enum rmap_status measure(const struct rmap_context *context, const struct request *request,
                                const struct rmap_map *map, const struct rmap_asked *asked,
                                int32_t detector, struct rmap_ghost_list *list, size_t row,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    const struct rmap_index_set only = {.low = detector, .span = 1};
    struct rmap_detector_ask ask = {.map = map,
                                    .detector = detector,
                                    .centre =
                                        scene->detector[detector].type == RMAP_DETECTOR_PLANE};
    struct rmap_criterion *criterion = NULL;
    struct rmap_which *which = NULL;
    struct rmap_detector_sums sums = {0};
    struct rmap_detector_image *image = NULL;
    st = rmap_detector_bins_read(scene, detector, &request->bins, &ask.bins, err);
    if (st == RMAP_OK)
        st = rmap_criterion_compile_with(list->ghost[row].criterion, asked->criteria, scene,
                                         &criterion, err);
    if (st == RMAP_OK)
        st = rmap_which_create(scene, &only, NULL, asked->criteria, criterion, &which, err);
    if (st == RMAP_OK)
        st = rmap_detector_sums_init_as(&sums, &ask, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_choice choice = {criterion, which};
    RMAP_TRY(rmap_image_scan(context, map, &choice, &sums, err));
    if (context->rank == 0) {
        st = rmap_detector_image_create(map, &sums, &image, err);
        if (st == RMAP_OK) {
            image->which = which;
            rmap_ghost_list_take(list, row, image);
            st = write_picture(request, image, &list->ghost[row], row, err);
        }
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_detector_image_destroy(image);
    rmap_detector_sums_fini(&sums);
    rmap_which_destroy(which);
    rmap_criterion_destroy(criterion);
    return st;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct rmap_map *map, const struct rmap_ghost_list *list,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    for (size_t i = 0; i < request->n_output; i++) {
        if (!rmap_output_is(request->output[i], ".csv"))
            continue;
        RMAP_TRY(rmap_whole_file_open(&whole, request->output[i], err));
        rmap_ghost_list_csv(list, whole.file);
        RMAP_TRY(rmap_whole_file_finish(&whole, err));
    }
    st = context->json
             ? rmap_json_print(rmap_json_of_map(rmap_ghost_list_json(list), map), stdout, err)
             : rmap_ghost_list_print(list, stdout, err);
    if (list->body && !context->quiet)
        (void)fprintf(stderr,
                      "%s is one object: 'by_face: true' of it in the scene, or set by a rule in "
                      "'attributes', tells which of its faces make ghosts\n",
                      list->body);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

static enum rmap_status run_ghosts(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_ghost_list *list = NULL;
    int32_t detector = -1;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map_or_scene(context, given, request.map_path, RAYS_DEFAULT, &map, err));
    st = rmap_find_detector(rmap_map_scene(map), request.detector, &detector, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, rmap_map_scene(map), &criterion, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_ghost_list_find(context, map, criterion, detector, request.level, request.top,
                                  &list, err));
    for (size_t row = 0; row < list->n; row++)
        RMAP_TRY(measure(context, &request, map, &asked, detector, list, row, err));
    if (context->rank == 0)
        st = show(context, &request, map, list, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_argument_list_free(request.output, request.n_output);
    rmap_ghost_list_destroy(list);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_ghosts = {
    .name = "ghosts",
    .summary = "the ghosts on a detector, by the surfaces that make them",
    .operands = "MAP|SCENE NAME [--top N] [-o OUT]",
    .help =
        "Lists the pairs of surfaces between which light was reflected on its way to the\n"
        "detector, those with most flux first, and what came by more reflections: flux, ratio to\n"
        "the direct image, brightest cell and where it lies, centroid and RMS radius, with the\n"
        "criterion that selects just these registrations for detector, draw or query:\n\n"
        "  raymap ghosts lens.raymap sensor --where 'source(sun)' -o ghosts.png\n\n"
        "Of a scene rays are traced into memory, which a first look takes:\n\n"
        "  raymap ghosts lens/scene.yaml sensor",
    .options = options,
    .min_operands = 2,
    .max_operands = 2,
    .run = run_ghosts,
};
