/* SPDX-License-Identifier: MIT
 *
 * raymap glare: the unified glare rating of an observer in a traced scene.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/detector/detector_image.h"
#include "analysis/photometry/glare.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/map/map_json.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/dim.h"
#include "mpi/command/find_camera.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/image_scan.h"

static const struct rmap_option options[] = {
    {"at", 0, "X,Y,Z", "the observer's eye, in the scene's unit"},
    {"look", 0, "X,Y,Z", "along which direction", "at"},
    {"camera", 'c', "NAME", "or from where a camera of the scene looks"},
    {"up", 0, "X,Y,Z", "what is above for the observer (default 0,0,1)"},
    {"eye", 0, "SIZE",
     "side of the square about the eye whose indirect light is the background's (default: of 0.25 "
     "m)"},
    {"background", 0, "L", "this background luminance, in cd/m2, instead"},
    RMAP_DIM_OPTIONS,
    {NULL}};

static const double eye_m = 0.25;

struct request {
    const char *map_path, *camera;
    struct rmap_vec3 at, look, up;
    double eye;        /* 0: the usual one */
    double background; /* NaN: of the map */
};

/* Three numbers; as it is where the option was not given. */
static enum rmap_status read_vector(const struct rmap_arguments *given, const char *name,
                                    struct rmap_vec3 *vector, struct rmap_error *err)
{
    double *number = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_argument_numbers(given, name, &number, &n, err);
    if (st == RMAP_OK && n == 3)
        *vector = rmap_vec3(number[0], number[1], number[2]);
    else if (st == RMAP_OK && rmap_argument(given, name))
        st = rmap_error_set(err, RMAP_USAGE, "--%s '%.60s': say three numbers, as 1,0,0", name,
                            rmap_argument(given, name));
    rmap_free(number);
    return st;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct request){.map_path = given->operand[0],
                                .camera = rmap_argument(given, "camera"),
                                .up = rmap_vec3(0, 0, 1),
                                .background = (double)NAN};
    RMAP_TRY(read_vector(given, "at", &request->at, err));
    RMAP_TRY(read_vector(given, "look", &request->look, err));
    RMAP_TRY(read_vector(given, "up", &request->up, err));
    RMAP_TRY(rmap_argument_number(given, "eye", &request->eye, err));
    RMAP_TRY(rmap_argument_number(given, "background", &request->background, err));
    const bool told = rmap_argument(given, "at") && rmap_argument(given, "look");
    if (told == (request->camera != NULL))
        return rmap_error_set(err, RMAP_USAGE,
                              "say who looks: --at X,Y,Z --look X,Y,Z, or --camera NAME");
    if (rmap_argument(given, "eye") && !(request->eye > 0.0))
        return rmap_error_set(err, RMAP_USAGE, "--eye %g: a length above 0", request->eye);
    if (rmap_argument(given, "background") && !(request->background > 0.0))
        st = rmap_error_set(err, RMAP_USAGE, "--background %g: a luminance above 0, in cd/m2",
                            request->background);
out:
    return st;
}

static enum rmap_status find_view(const struct rmap_scene *scene, const struct request *request,
                                  struct rmap_glare_view *view, struct rmap_error *err)
{
    const struct rmap_camera *camera = NULL;
    if (!request->camera)
        return rmap_glare_view_init(request->at, request->look, request->up, view, err);
    const enum rmap_status st =
        rmap_find_camera(scene, request->map_path, request->camera, &camera, err);
    return st == RMAP_OK ? rmap_glare_view_init(camera->at, camera->forward, request->up, view, err)
                         : st;
}

/* A plane about the eye, across the line of sight. */
static enum rmap_status lay_eye(const struct rmap_map *map, const struct request *request,
                                const struct rmap_glare_view *view, struct rmap_overlay **overlay,
                                struct rmap_error *err)
{
    const double side = request->eye > 0.0 ? request->eye : eye_m / rmap_map_scene(map)->unit_m;
    char text[512];
    struct rmap_diagnostics diagnostics;
    const int n = snprintf(text, sizeof text,
                           "detectors: [{name: eye of the observer, type: plane, at: [%.17g, "
                           "%.17g, %.17g], direction: [%.17g, %.17g, %.17g], size: [%.17g, "
                           "%.17g], cells: 1, side: front}]\n",
                           view->at.x, view->at.y, view->at.z, view->look.x, view->look.y,
                           view->look.z, side, side);
    const struct rmap_receivers receivers = {.path = "eye of the observer",
                                             .text = text,
                                             .nbytes = (size_t)n,
                                             .diagnostics = &diagnostics};
    rmap_diagnostics_init(&diagnostics, receivers.path);
    const enum rmap_status st = rmap_overlay_create(map, &receivers, overlay, err);
    if (st != RMAP_OK)
        rmap_diagnostics_print(&diagnostics, stderr);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}

/* Collective. Lux on the eye of light that was reflected once or more; on rank 0. */
static enum rmap_status find_indirect(const struct rmap_context *context,
                                      const struct rmap_map *map, const struct request *request,
                                      const struct rmap_glare_view *view, struct rmap_glare *glare,
                                      struct rmap_error *err)
{
    struct rmap_overlay *overlay = NULL;
    struct rmap_which *which = NULL;
    struct rmap_detector_image *image = NULL;
    struct rmap_detector_sums sums = {0};
    enum rmap_status st = lay_eye(map, request, view, &overlay, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    struct rmap_detector_ask ask = {
        .map = map, .overlay = overlay, .detector = (int32_t)rmap_overlay_first(overlay)};
    const struct rmap_index_set eye = {.low = ask.detector, .span = 1};
    rmap_detector_bins_own(scene, ask.detector, &ask.bins);
    st = rmap_which_create(scene, &eye, "where hit(*, reflect) >= 1", NULL, NULL, &which, err);
    if (st == RMAP_OK)
        st = rmap_detector_sums_init_as(&sums, &ask, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_image_scan(context, map, &(struct rmap_choice){NULL, which}, &sums, err));
    if (context->rank == 0)
        st = rmap_detector_image_create(map, &sums, &image, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (image) {
        glare->indirect = image->mean;
        glare->indirect_error = image->mean_error;
        glare->registrations = image->registrations;
    }
out:
    rmap_detector_image_destroy(image);
    rmap_detector_sums_fini(&sums);
    rmap_which_destroy(which);
    rmap_overlay_destroy(overlay);
    return st;
}

static enum rmap_status show(const struct rmap_context *context, const struct rmap_map *map,
                             const struct rmap_glare *glare, struct rmap_error *err)
{
    if (context->json)
        return rmap_json_print(rmap_json_of_map(rmap_glare_json(glare), map), stdout, err);
    rmap_dim_print(map);
    return rmap_glare_print(glare, stdout, err);
}

static enum rmap_status run_glare(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_accel *accel = NULL;
    struct rmap_glare_view view;
    struct rmap_glare *glare = NULL;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_map(context, request.map_path, &map, err));
    st = rmap_dim_read(given, map, err);
    if (st == RMAP_OK)
        st = find_view(rmap_map_scene(map), &request, &view, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank == 0) {
        st = rmap_accel_create(rmap_map_scene(map), context->n_thread, &accel, err);
        if (st == RMAP_OK)
            st = rmap_glare_look(map, accel, &view, &glare, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    if (isnan(request.background))
        RMAP_TRY(find_indirect(context, map, &request, &view, glare, err));
    if (glare) {
        rmap_glare_conclude(
            glare, isnan(request.background) ? glare->indirect / RMAP_PI : request.background,
            glare->indirect_error / RMAP_PI);
        st = show(context, map, glare, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_glare_destroy(glare);
    rmap_accel_destroy(accel);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_glare = {
    .name = "glare",
    .summary = "an observer's discomfort glare by luminaires (UGR)",
    .operands = "MAP --at X,Y,Z --look X,Y,Z | --camera NAME",
    .help =
        "The unified glare rating of CIE 117:1995, 8 lg(0.25/Lb sum L^2 w/p^2), of who stands\n"
        "there and looks along there: L of the luminaires with a luminous opening and of\n"
        "Lambertian areas, from their files and sizes, w of what of them no opaque body hides, p\n"
        "by Guth's table; Lb from the map, of the light on the eye that was reflected once or\n"
        "more. Skies and suns are no luminaires; --dim sky=0,sun=0 takes them from the "
        "background:\n\n"
        "  raymap glare office.raymap --at=-2.2,0,1.2 --look 1,0,0 --dim sky=0,sun=0\n\n"
        "The table of a luminaire is of `raymap check SCENE --lamp NAME`.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_glare,
};
