/* SPDX-License-Identifier: MIT
 *
 * raymap irradiance: light that falls on objects, by triangle.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/criterion_names.h"
#include "analysis/detector/irradiance_image.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "base/unit.h"
#include "io/export/raster.h"
#include "io/file/diagnostics.h"
#include "io/map/map_json.h"
#include "mpi/answer/draw_request.h"
#include "mpi/answer/irradiance_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/dim.h"
#include "mpi/command/find_camera.h"
#include "mpi/command/hint.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/luminous.h"
#include "mpi/command/map_name.h"
#include "mpi/command/output.h"
#include "mpi/command/overlay_load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

enum { OPERANDS_MAX = 1000 };

static const struct rmap_option options[] = {
    {"where", 'w', "CRITERION", "of the rays that match only, such as 'source(sun)'"},
    RMAP_ASKED_OPTIONS,
    RMAP_RECEIVERS_OPTION,
    RMAP_DIM_OPTIONS,
    {"side", 0, "SIDE",
     "light that arrives on the front of the surfaces (of closed bodies the outside), their back, "
     "or both (default); pictures show that side alone",
     .words = "front back both"},
    {"cells", 0, "LENGTH",
     "about so long, as '5 cm': larger triangles are halved, those of half and less joined; or "
     "triangles: a mesh's own (default: 1/40 of the objects' size)",
     .words = "triangles"},
    {"uv", 0, "WxH",
     "so many cells over the texture coordinates of meshes (geometries with `uv: true`) in place "
     "of "
     "--cells; pictures show the texture, or with --eye or --camera the bodies"},
    {"faces", 0, "F", "of meshes these faces alone, by number or name, as bottom or 0,2"},
    {"quantity", 0, "Q",
     "irradiance, illuminance (of sources in W with a spectrum, too; default: by the sources' "
     "unit)",
     .words = "irradiance illuminance"},
    {"unit", 0, "UNIT", "another one that fits, such as klx or mW/cm2"},
    {"output", 'o', "OUT" RMAP_ARGUMENT_AGAIN,
     "OUT.png, .svg: the bodies in false colours; .vtp: for ParaView; .glb, .gltf: a glTF scene; "
     ".h5, .npz, .csv (with --uv .npy): numbers; again for more"},
    {"absorbed", 0, NULL, "in colours what is absorbed, not what arrives", "output"},
    {"log", 0, NULL, "logarithmic colours (default: as the values are spread)", "output"},
    {"eye", 0, "AZIMUTH,ELEVATION", "where the picture is seen from, degrees (default -62,28)",
     "output"},
    {"camera", 0, "NAME", "as this camera of the scene sees it, in perspective", "output"},
    {"force", 'f', NULL, "replace OUT", "output"},
    {NULL}};

static const char *const suffixes[] = {".png", ".svg", ".vtp", ".glb", ".gltf",
                                       ".h5",  ".npz", ".csv", NULL};
static const char *const suffixes_uv[] = {".png", ".svg", ".vtp", ".glb", ".gltf",
                                          ".h5",  ".npz", ".npy", ".csv", NULL};

struct request {
    const char *map_path, *where, *cells, *uv, *quantity, *unit, *camera;
    char **name; /* [n_name] of objects and groups, borrowed */
    size_t n_name;
    char **face; /* [n_face] */
    size_t n_face;
    char **output; /* [n_output] */
    size_t n_output;
    enum rmap_side side;
    bool has_eye;
    double eye[2];
    struct rmap_irradiance_out out;
};

static void fini(struct request *request)
{
    rmap_argument_list_free(request->face, request->n_face);
    rmap_argument_list_free(request->output, request->n_output);
}

static enum rmap_status read_side(const char *text, enum rmap_side *side, struct rmap_error *err)
{
    static const char *const word[] = {
        [RMAP_SIDE_FRONT] = "front", [RMAP_SIDE_BACK] = "back", [RMAP_SIDE_BOTH] = "both"};
    *side = RMAP_SIDE_BOTH;
    if (!text)
        return RMAP_OK;
    for (int k = 0; k < 3; k++)
        if (strcmp(text, word[k]) == 0) {
            *side = (enum rmap_side)k;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_USAGE, "--side '%.40s': say front, back or both", text);
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool force = rmap_argument(given, "force") != NULL;
    const char *eye = rmap_argument(given, "eye");
    *request = (struct request){
        .map_path = given->operand[0],
        .name = given->operand + 1,
        .n_name = (size_t)given->n_operand - 1,
        .where = rmap_argument(given, "where"),
        .cells = rmap_argument(given, "cells"),
        .uv = rmap_argument(given, "uv"),
        .quantity = rmap_argument(given, "quantity"),
        .unit = rmap_argument(given, "unit"),
        .camera = rmap_argument(given, "camera"),
        .has_eye = eye != NULL,
        .out = {.what = rmap_argument(given, "absorbed") ? RMAP_IRRADIANCE_ABSORBED
                                                         : RMAP_IRRADIANCE_ARRIVING,
                .scale = rmap_argument(given, "log") ? RMAP_SCALE_LOGARITHMIC : RMAP_SCALE_AUTO}};
    RMAP_TRY(read_side(rmap_argument(given, "side"), &request->side, err));
    if (request->quantity && strcmp(request->quantity, "irradiance") != 0 &&
        strcmp(request->quantity, "illuminance") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--quantity '%.40s': say irradiance or illuminance",
                              request->quantity);
    if (eye && request->camera)
        return rmap_error_set(err, RMAP_USAGE,
                              "--camera says where the scene is seen from: leave out --eye");
    if (request->uv && request->cells)
        return rmap_error_set(err, RMAP_USAGE, "--uv says what the cells are: leave out --cells");
    request->out.over_texture = request->uv && !eye && !request->camera;
    if (eye)
        RMAP_TRY(rmap_read_eye(eye, request->eye, err));
    RMAP_TRY(rmap_argument_list(given, "faces", &request->face, &request->n_face, err));
    RMAP_TRY(rmap_argument_each(given, "output", &request->output, &request->n_output, err));
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_output_check(request->output[i], request->uv ? suffixes_uv : suffixes, force,
                                   err));
out:
    return st;
}

/* "0.2", "5 cm" or "triangles", in the scene's unit; 0: not given. */
static enum rmap_status read_length(const struct rmap_scene *scene, const char *text,
                                    double *length, struct rmap_error *err)
{
    char *end = NULL;
    *length = 0.0;
    if (!text)
        return RMAP_OK;
    *length = (double)INFINITY;
    if (strcmp(text, "triangles") == 0)
        return RMAP_OK;
    *length = strtod(text, &end);
    const bool number = end != text && *length > 0.0 && isfinite(*length);
    end += strspn(end, " ");
    const struct rmap_written_unit *unit =
        *end ? rmap_unit_of_scene(end, RMAP_DIMENSION_LENGTH) : NULL;
    if (!number || (*end && !unit))
        return rmap_error_set(err, RMAP_USAGE,
                              "--cells '%.40s': give a length above 0, a unit behind it if wanted, "
                              "as '5 cm'; or triangles",
                              text);
    *length *= unit ? unit->size / scene->unit_m : 1.0;
    return RMAP_OK;
}

static enum rmap_status read_uv(const char *text, uint32_t uv[2], struct rmap_error *err)
{
    char *end = NULL;
    unsigned long n[2] = {strtoul(text, &end, 10), 0};
    n[1] = *end == 'x' ? strtoul(end + 1, &end, 10) : 0;
    const bool good = text[0] >= '0' && text[0] <= '9' && *end == 0 && n[0] > 0 && n[1] > 0;
    if (!good || n[0] > RMAP_IRRADIANCE_CELLS_MAX || n[1] > RMAP_IRRADIANCE_CELLS_MAX / n[0])
        return rmap_error_set(err, RMAP_USAGE,
                              "--uv '%.40s': say columns x rows, as 256x256, at most %u cells",
                              text, RMAP_IRRADIANCE_CELLS_MAX);
    uv[0] = (uint32_t)n[0];
    uv[1] = (uint32_t)n[1];
    return RMAP_OK;
}

static enum rmap_status refuse_name(const struct rmap_names *names, const char *text,
                                    struct rmap_error *err)
{
    const struct rmap_name *other = rmap_names_lookup(names, text);
    size_t n = 0;
    const char **known = rmap_alloc(names->n + 1, sizeof *known);
    for (size_t i = 0; known && i < names->n; i++)
        if (names->name[i].kind == RMAP_NAME_OBJECT || names->name[i].kind == RMAP_NAME_GROUP)
            known[n++] = names->name[i].text;
    const char *nearest = known ? rmap_nearest_word(text, known, n) : NULL;
    if (other)
        (void)rmap_error_set(err, RMAP_INPUT, "'%s' is %s, no object%s", text,
                             rmap_name_kind_phrase(other->kind),
                             other->kind == RMAP_NAME_DETECTOR ? ": raymap detector shows it" : "");
    else
        (void)rmap_error_set(err, RMAP_INPUT, "no object or group named '%s' in this map%s%s%s",
                             text, nearest ? " (did you mean '" : "; raymap info lists them",
                             nearest ? nearest : "", nearest ? "'?)" : "");
    rmap_free(known);
    return RMAP_INPUT;
}

/* mark: [n_object] */
static enum rmap_status mark_objects(const struct rmap_scene *scene, const struct request *request,
                                     uint8_t *mark, struct rmap_error *err)
{
    struct rmap_names *names = NULL;
    enum rmap_status st = rmap_names_create(scene, &names, err);
    for (size_t i = 0; i < request->n_name && st == RMAP_OK; i++) {
        bool found = false;
        rmap_names_mark(names, request->name[i], true, RMAP_WANTED_OBJECT, mark, &found);
        if (!found)
            st = refuse_name(names, request->name[i], err);
    }
    rmap_names_destroy(names);
    return st;
}

static enum rmap_status cut(const struct rmap_scene *scene, const struct request *request,
                            struct rmap_irradiance_cells **cells_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *mark = rmap_alloc(scene->n_object + 1, 1);
    struct rmap_irradiance_choice choice = {
        .object = mark, .face = (const char *const *)request->face, .n_face = request->n_face};
    if (!mark)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the objects' names");
    RMAP_TRY(mark_objects(scene, request, mark, err));
    RMAP_TRY(read_length(scene, request->cells, &choice.length, err));
    if (request->uv) {
        choice.length = (double)INFINITY;
        RMAP_TRY(read_uv(request->uv, choice.uv, err));
    }
    RMAP_TRY(rmap_irradiance_cells_create(scene, &choice, cells_ret, err));
    for (size_t i = 0; i < request->n_output && (*cells_ret)->n_part > 1; i++)
        if (request->out.over_texture && rmap_picture_kind(request->output[i]))
            st = rmap_error_set(err, RMAP_USAGE,
                                "a picture of a texture is of one object, and these are %zu: ask "
                                "for one, or say --eye for a picture of the bodies",
                                (*cells_ret)->n_part);
out:
    rmap_free(mark);
    return st;
}

/* Everything that can be wrong, before rays are read. */
static enum rmap_status choose(const struct request *request, const struct rmap_map *map,
                               struct rmap_irradiance_cells **cells_ret,
                               struct rmap_irradiance_ask *ask, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    const struct rmap_image_unit *unit = NULL;
    *ask = (struct rmap_irradiance_ask){.map = map, .side = request->side};
    RMAP_TRY(rmap_ask_luminous(scene, request->quantity, &ask->luminous, err));
    if (request->quantity && scene->flux_unit == RMAP_FLUX_LM &&
        strcmp(request->quantity, "irradiance") == 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "--quantity irradiance: the sources are in lm: ask for illuminance");
    RMAP_TRY(rmap_image_unit_find(RMAP_PER_AREA, ask->luminous ? RMAP_FLUX_LM : scene->flux_unit,
                                  request->unit, &unit, err));
    RMAP_TRY(cut(scene, request, cells_ret, err));
    ask->cells = *cells_ret;
out:
    return st;
}

static void warn(const struct rmap_irradiance_cells *cells)
{
    if (cells->n_twice > 0)
        fprintf(
            stderr,
            "raymap: %s of the texture hold surface twice in one place (charts overlap or repeat): "
            "light and area of all of it are summed\n",
            rmap_counted(cells->n_twice, "cell").text);
    if (cells->n_without > 0)
        fprintf(stderr, "raymap: %s have no texture coordinates: their light is in no cell\n",
                rmap_counted(cells->n_without, "triangle").text);
}

/* On rank 0. */
static enum rmap_status show(const struct rmap_context *context, struct request *request,
                             const struct rmap_map *map, const struct rmap_irradiance_image *image,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char title[2 * RMAP_MAP_NAME_LEN + 64], name[RMAP_MAP_NAME_LEN], on[RMAP_MAP_NAME_LEN];
    size_t len = 0;
    for (size_t i = 0; i < request->n_name && len < sizeof on / 2; i++)
        len += (size_t)snprintf(on + len, sizeof on - len, "%s%.100s", i > 0 ? ", " : "",
                                request->name[i]);
    rmap_map_name(request->map_path, name);
    (void)snprintf(title, sizeof title, "%s: %s%s in %s", on, image->quantity,
                   request->out.what == RMAP_IRRADIANCE_ABSORBED ? " absorbed" : "", name);
    request->out.title = title;
    request->out.eye = request->has_eye ? request->eye : NULL;
    if (request->camera)
        RMAP_TRY(rmap_find_camera(rmap_map_scene(map), request->map_path, request->camera,
                                  &request->out.camera, err));
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_irradiance_write(image, &request->out, request->output[i], err));
    if (context->json)
        return rmap_json_print(rmap_json_of_map(rmap_irradiance_image_json(image), map), stdout,
                               err);
    st = rmap_irradiance_image_print(image, stdout, err);
    rmap_dim_print(map);
out:
    return st;
}

/* Collective. The image on rank 0. */
static enum rmap_status sum_up(const struct rmap_context *context, const struct rmap_fold *fold,
                               const char *unit, struct rmap_irradiance_image **image_ret,
                               struct rmap_error *err)
{
    void *state = NULL;
    enum rmap_status st = rmap_fold_run(context, fold, &state, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_irradiance_image_create(state, unit, image_ret, err);
    fold->kind->destroy(state);
    return rmap_agree(context, st, err);
}

static enum rmap_status run_irradiance(const struct rmap_context *context,
                                       const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_overlay *overlay = NULL;
    struct rmap_asked asked = {0};
    struct rmap_criterion *criterion = NULL;
    struct rmap_irradiance_cells *cells = NULL;
    struct rmap_irradiance_ask ask;
    struct rmap_irradiance_image *image = NULL;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_asked_load_where(context, given, &request.where, &asked, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
    RMAP_TRY(rmap_agree(context, rmap_dim_read(given, map, err), err));
    st = choose(&request, map, &cells, &ask, err);
    if (st == RMAP_OK && asked.n > 0)
        st = rmap_asked_compile(context, &asked, 0, rmap_scene_with(map, overlay), &criterion, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_fold fold = {.kind = &rmap_irradiance_kind,
                                   .context = &ask,
                                   .map = map,
                                   .criterion = criterion,
                                   .columns = rmap_irradiance_columns(&ask),
                                   .overlay = overlay};
    RMAP_TRY(sum_up(context, &fold, request.unit, &image, err));
    if (context->rank == 0) {
        const struct rmap_choice choice = {criterion, NULL};
        image->criterion = criterion ? rmap_criterion_text(criterion) : NULL;
        warn(cells);
        rmap_tell_hint(context, map, &choice, image->object[cells->n_part].flux[0] > 0.0);
        st = show(context, &request, map, image, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    fini(&request);
    rmap_irradiance_image_destroy(image);
    rmap_irradiance_cells_destroy(cells);
    rmap_criterion_destroy(criterion);
    rmap_asked_fini(&asked);
    rmap_overlay_destroy(overlay);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_irradiance = {
    .name = "irradiance",
    .summary = "light on the surface of objects, in false colours",
    .operands = "MAP OBJECT... [--where CRITERION] [--cells LENGTH | --uv WxH] [-o OUT]",
    .help =
        "Cuts objects (or groups, or names with * and ?) into cells and tells of each the flux\n"
        "that arrives and what of it is absorbed, per area, with standard errors: lx or W/m2.\n"
        "Cells are the triangles of a mesh, large ones halved and small ones joined; along and\n"
        "around any other shape. With --where, of the matching rays alone:\n\n"
        "  raymap irradiance office.raymap floor 'desk*' --cells 10cm -o office.glb",
    .options = options,
    .min_operands = 2,
    .max_operands = OPERANDS_MAX,
    .run = run_irradiance,
};
