/* SPDX-License-Identifier: MIT
 *
 * raymap voxels: light that passes and that is absorbed in the voxels of a box.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/voxel_image.h"
#include "analysis/figure/figure_detector.h"
#include "base/alloc.h"
#include "io/export/image_data.h"
#include "io/export/raster.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/answer/grid_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/dim.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'source(sun)'"},
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    RMAP_DIM_OPTIONS,
    {"cells", 0, "NXxNYxNZ", "into so many voxels, as 40x40x80 or 50 (default 32x32x32)"},
    {"region", 0, "BOX",
     "x0,y0,z0,x1,y1,z1, as -1,-1,0,1,1,5 cm (default: the box about the scene's objects)"},
    {"slice", 0, "PLACE",
     "of a picture, as z=0.5, in the scene's unit (default: the middle, across z)"},
    {"quantity", 0, "Q", "of a picture: fluence (default), absorbed, surfaces",
     .words = "fluence absorbed surfaces"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.vti: for ParaView; .h5, .npz, .csv: numbers; .png, .svg: a picture of a slice; again for "
     "more"},
    {"log", 0, NULL, "logarithmic scale in the picture (default: as its values are spread)",
     "output"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

static const char *const suffixes[] = {".vti", ".h5", ".npz", ".csv", ".png", ".svg", NULL};

struct request {
    const char *map_path, *where, *cells, *region;
    char **output; /* [n_output] */
    size_t n_output;
    enum rmap_voxel_what what; /* of a picture */
    int axis;                  /* across which it lies, */
    double place;              /* and where; NaN: in the middle */
    bool logarithmic;
};

static enum rmap_status read_slice(const char *text, struct request *request,
                                   struct rmap_error *err)
{
    char *end = NULL;
    request->axis = 2;
    request->place = (double)NAN;
    if (!text)
        return RMAP_OK;
    const char *axis = *text ? strchr("xyz", *text) : NULL;
    if (axis && text[1] == '=')
        request->place = strtod(text + 2, &end);
    if (!end || end == text + 2 || *end || !isfinite(request->place))
        return rmap_error_set(err, RMAP_USAGE, "--slice '%.40s': say where, as z=0.5 or x=-2",
                              text);
    request->axis = (int)(axis - "xyz");
    return RMAP_OK;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    static const char *const word[RMAP_VOXEL_PARTS] = {"fluence", "absorbed", "surfaces"};
    const char *quantity = rmap_argument(given, "quantity"), *cells = rmap_argument(given, "cells");
    int what = 0;
    *request = (struct request){.map_path = given->operand[0],
                                .where = rmap_argument(given, "where"),
                                .cells = cells ? cells : "32",
                                .region = rmap_argument(given, "region"),
                                .logarithmic = rmap_argument(given, "log") != NULL};
    while (quantity && what < RMAP_VOXEL_PARTS && strcmp(quantity, word[what]) != 0)
        what++;
    if (what == RMAP_VOXEL_PARTS)
        return rmap_error_set(err, RMAP_USAGE,
                              "--quantity '%.40s': say fluence, absorbed or surfaces", quantity);
    request->what = (enum rmap_voxel_what)what;
    enum rmap_status st = read_slice(rmap_argument(given, "slice"), request, err);
    if (st == RMAP_OK)
        st = rmap_argument_each(given, "output", &request->output, &request->n_output, err);
    for (size_t i = 0; i < request->n_output && st == RMAP_OK; i++)
        st = rmap_output_check(request->output[i], suffixes, rmap_argument(given, "force") != NULL,
                               err);
    return st;
}

static enum rmap_status write_picture(const struct request *request,
                                      const struct rmap_voxel_image *image, const char *path,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_voxel_grid *grid = &image->grid;
    const int axis = request->axis;
    const double place =
        isnan(request->place) ? 0.5 * (grid->low[axis] + grid->high[axis]) : request->place;
    struct rmap_voxel_slice slice = {.name = ""};
    struct rmap_svg *svg = NULL;
    if (!(place >= grid->low[axis] && place <= grid->high[axis]))
        return rmap_error_set(err, RMAP_USAGE, "--slice %c=%g lies beside the voxels, %g to %g",
                              "xyz"[axis], place, grid -> low[axis], grid -> high[axis]);
    const double layer = fmin((place - grid->low[axis]) / grid->step[axis], grid->n[axis] - 1.0);
    char size[128];
    (void)snprintf(size, sizeof size, "voxels of %.4g x %.4g x %.4g %.20s", grid->step[0],
                   grid->step[1], grid->step[2], image->scene->unit);
    const struct rmap_figure_detector figure = {
        .criterion = request->where,
        .sums = size,
        .scale = request->logarithmic ? RMAP_SCALE_LOGARITHMIC : RMAP_SCALE_AUTO};
    RMAP_TRY(rmap_voxel_slice_init(image, request->what, axis, (uint32_t)layer, &slice, err));
    RMAP_TRY(rmap_figure_detector(&slice.image, &figure, &svg, err));
    st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
out:
    rmap_svg_destroy(svg);
    rmap_voxel_slice_fini(&slice);
    return st;
}

/* Centres along each axis, then value and error of each part. */
static enum rmap_status write_arrays(const struct rmap_voxel_image *image, const char *path,
                                     struct rmap_error *err)
{
    enum { AXES = 3, ARRAYS = AXES + 2 * RMAP_VOXEL_PARTS };
    static const char *const axis[AXES] = {"x", "y", "z"};
    const struct rmap_voxel_grid *grid = &image->grid;
    const struct rmap_grid_text text[] = {
        {"criterion", image->criterion ? image->criterion : "all"}};
    struct rmap_grid_array array[ARRAYS];
    char name[RMAP_VOXEL_PARTS][64];
    enum rmap_status st = RMAP_OK;
    double *centre = rmap_alloc((size_t)grid->n[0] + grid->n[1] + grid->n[2], sizeof *centre);
    if (!centre)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for voxels");
    double *at = centre;
    for (int k = 0; k < AXES; at += grid->n[k++]) {
        for (uint32_t i = 0; i < grid->n[k]; i++)
            at[i] = grid->low[k] + (i + 0.5) * grid->step[k];
        array[k] = (struct rmap_grid_array){axis[k], image->scene->unit, "centres of the voxels",
                                            1,       {grid->n[k]},       at};
    }
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++) {
        const struct rmap_voxel_part *part = &image->part[k];
        (void)snprintf(name[k], sizeof name[k], "%s_error", part->name);
        for (int e = 0; e < 2; e++)
            array[AXES + 2 * k + e] =
                (struct rmap_grid_array){e ? name[k] : part->name,
                                         part->unit,
                                         e ? "standard error" : part->description,
                                         3,
                                         {grid->n[2], grid->n[1], grid->n[0]},
                                         e ? part->standard_error : part->value};
    }
    struct rmap_image_data box = {.unit_m = image->scene->unit_m};
    memcpy(box.n, grid->n, sizeof box.n);
    memcpy(box.low, grid->low, sizeof box.low);
    memcpy(box.step, grid->step, sizeof box.step);
    st = rmap_output_is(path, ".vti")
             ? rmap_image_data_write(&box, array, ARRAYS, text, 1, path, err)
             : rmap_grid_write(array, ARRAYS, text, 1, path, err);
    rmap_free(centre);
    return st;
}

static enum rmap_status put_csv(const void *image, FILE *file, struct rmap_error *err)
{
    (void)err;
    rmap_voxel_image_csv(image, file);
    return RMAP_OK;
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, const struct request *request,
                             const struct rmap_map *map, const struct rmap_voxel_image *image,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < request->n_output; i++) {
        const char *path = request->output[i];
        if (rmap_output_is(path, ".csv"))
            RMAP_TRY(rmap_whole_file_put(path, put_csv, image, err));
        else if (rmap_picture_kind(path) != RMAP_PICTURE_NONE)
            RMAP_TRY(write_picture(request, image, path, err));
        else
            RMAP_TRY(write_arrays(image, path, err));
    }
    if (context->json)
        return rmap_json_print(rmap_json_of_map(rmap_voxel_image_json(image), map), stdout, err);
    rmap_voxel_image_print(image, stdout);
    rmap_dim_print(map);
out:
    return st;
}

/* Collective. The image on rank 0. */
static enum rmap_status sum_up(const struct rmap_context *context, const struct rmap_fold *fold,
                               struct rmap_voxel_image **image_ret, struct rmap_error *err)
{
    void *state = NULL;
    enum rmap_status st = rmap_fold_run(context, fold, &state, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_voxel_image_create(state, image_ret, err);
    fold->kind->destroy(state);
    return rmap_agree(context, st, err);
}

static enum rmap_status run_voxels(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_voxel_image *image = NULL;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    RMAP_TRY(rmap_agree(context, rmap_dim_read(given, map, err), err));
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    struct rmap_voxel_ask ask = {.map = map};
    st = rmap_voxel_grid_read(scene, request.cells, request.region, &ask.grid, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, scene, &criterion, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_fold fold = {.kind = &rmap_voxel_kind,
                                   .context = &ask,
                                   .map = map,
                                   .criterion = criterion,
                                   .columns = rmap_voxel_columns(scene),
                                   .overlay = overlay};
    RMAP_TRY(sum_up(context, &fold, &image, err));
    if (context->rank == 0) {
        const struct rmap_choice choice = {criterion, NULL};
        request.where = criterion ? rmap_criterion_text(criterion) : NULL;
        image->criterion = request.where;
        rmap_tell_hint(context, map, &choice, image->part[RMAP_VOXEL_PASSING].total > 0.0);
        st = show(context, &request, map, image, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_argument_list_free(request.output, request.n_output);
    rmap_voxel_image_destroy(image);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_overlay_destroy(overlay);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_voxels = {
    .name = "voxels",
    .summary = "fluence rate and absorbed power in the voxels of a box",
    .operands = "MAP [--region BOX] [--cells N] [--where CRITERION] [-o OUT]",
    .help = "Cuts a box into voxels and tells of each the fluence rate (flux times length of way,\n"
            "over the volume) and the power absorbed in media per volume, with standard errors;\n"
            "what surfaces absorb is told apart; with --where, of the matching rays alone:\n\n"
            "  raymap voxels skin.raymap --region 0,0,0,1,1,2mm --cells 99 -o light.vti",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_voxels,
};
