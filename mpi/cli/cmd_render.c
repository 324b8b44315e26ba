/* SPDX-License-Identifier: MIT
 *
 * raymap render: what a camera of the scene sees.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/image_unit.h"
#include "analysis/table/figure_axes.h"
#include "analysis/table/photo.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/diagnostics.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/balance.h"
#include "mpi/command/find_camera.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/at_hand.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/render_run.h"

static const struct rmap_option options[] = {
    {"output", 'o', "OUT...", "OUT.png: as a screen shows it; OUT.exr: linear values; or both"},
    {"camera", 'c', "NAME", "which of the scene's cameras (default: the first)"},
    {"samples", 'n', "N",
     "paths per pixel (default 64; with --time-limit as many as there is time "
     "for)"},
    {"time-limit", 't', "TIME", "stop in good order after 90s, 3h50min, 1:30:00"},
    {"size", 0, "WxH", "pixels, instead of the camera's resolution"},
    {"exposure", 'e', "X", "what unit radiance is shown as, 1 being white"},
    {"clamp", 0, "L",
     "most luminance (cd/m2, W/(m2 sr)) that a path gets of a lamp met after it has scattered: "
     "takes bright dots away, and tells how much light with them"},
    {"preview", 'p', NULL, "one path per pixel, and how many such pictures a second"},
    {"seed", 's', "S", "of the random numbers (default 1)"},
    {"force", 'f', NULL, "replace OUT", "output"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

static const char *const suffixes[] = {".png", ".exr", NULL};
enum { DEFAULT_SAMPLES = 64, PIXELS_PER_SIDE_MAX = 65535 };

/* Of so many samples an error of a pixel above this part of the mean luminance is one of few bright
 * ones; a clamp at this multiple of it takes them away. */
enum { DOTS_SAMPLES = 16 };
static const double DOTS_NOISE = 0.5, DOTS_CLAMP = 10.0;

struct request {
    const char *scene_path, *camera;
    char **output;
    size_t n_output;
    uint64_t n_sample, seed;
    bool has_samples, preview;
    double time_limit_s, exposure, clamp;
    uint32_t size[2]; /* 0: the camera's */
    struct rmap_scene_options scene;
};

struct session {
    const struct rmap_context *context;
    struct request request;
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_accel *accel;
    const struct rmap_camera *camera;
    struct rmap_renderer *renderer;
    struct rmap_render_run run;
    float *rgb;      /* of the last picture, on rank 0 */
    uint8_t *lit;    /* which of its pixels show no light itself */
    double exposure; /* of the last picture */
    bool shown;      /* there is one of this step, on rank 0 */
};

/* ---- what is asked ---- */

static enum rmap_status read_size(const char *text, uint32_t size[2], struct rmap_error *err)
{
    char *end = NULL;
    if (!text)
        return RMAP_OK;
    for (int i = 0; i < 2; i++) {
        const char *from = i == 0 ? text : end + 1;
        unsigned long n = *from >= '0' && *from <= '9' ? strtoul(from, &end, 10) : 0;
        if (n < 1 || n > PIXELS_PER_SIDE_MAX || *end != (i == 0 ? 'x' : 0))
            return rmap_error_set(err, RMAP_USAGE,
                                  "--size '%s': say WIDTHxHEIGHT in pixels, as in 800x600", text);
        size[i] = (uint32_t)n;
    }
    return RMAP_OK;
}

static enum rmap_status read_outputs(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool force = rmap_argument(given, "force") != NULL;
    RMAP_TRY(rmap_argument_each(given, "output", &request->output, &request->n_output, err));
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_output_check(request->output[i], suffixes, force, err));
    if (request->n_output == 0 && !request->preview)
        st = rmap_error_set(err, RMAP_USAGE, "say where to: -o OUT.png or -o OUT.exr");
out:
    return st;
}

static enum rmap_status read_numbers(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_argument_count(given, "samples", &request->n_sample, err));
    RMAP_TRY(rmap_argument_count(given, "seed", &request->seed, err));
    RMAP_TRY(rmap_argument_seconds(given, "time-limit", &request->time_limit_s, err));
    RMAP_TRY(rmap_argument_number(given, "exposure", &request->exposure, err));
    RMAP_TRY(rmap_argument_number(given, "clamp", &request->clamp, err));
    RMAP_TRY(read_size(rmap_argument(given, "size"), request->size, err));
    if (request->n_sample < 1)
        st = rmap_error_set(err, RMAP_USAGE, "--samples must be at least 1");
    else if (rmap_argument(given, "exposure") && !(request->exposure > 0.0))
        st = rmap_error_set(err, RMAP_USAGE, "--exposure must be greater than 0");
    else if (rmap_argument(given, "clamp") && !(request->clamp > 0.0))
        st = rmap_error_set(err, RMAP_USAGE, "--clamp must be greater than 0");
    else if (request->preview && request->has_samples)
        st = rmap_error_set(err, RMAP_USAGE, "--preview takes one sample; leave out --samples");
out:
    return st;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct request){.scene_path = given->operand[0],
                                .camera = rmap_argument(given, "camera"),
                                .n_sample = DEFAULT_SAMPLES,
                                .has_samples = rmap_argument(given, "samples") != NULL,
                                .preview = rmap_argument(given, "preview") != NULL,
                                .seed = 1};
    RMAP_TRY(read_numbers(given, request, err));
    RMAP_TRY(read_outputs(given, request, err));
    if (request->preview)
        request->n_sample = 1;
    else if (request->time_limit_s > 0.0 && !request->has_samples)
        request->n_sample = UINT32_MAX;
    st = rmap_scene_options_read(given, &request->scene, err);
out:
    return st;
}

/* ---- the picture ---- */

static enum rmap_status prepare(struct session *session, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct request *request = &session->request;
    RMAP_TRY(rmap_load_scene(session->context, request->scene_path, &request->scene,
                             &session->bundle, &session->scene, err));
    RMAP_TRY(rmap_find_camera(session->scene, request->scene_path, request->camera,
                              &session->camera, err));
    if (request->size[0] == 0)
        memcpy(request->size, session->camera->resolution, sizeof request->size);
    rmap_scene_include(session->scene, session->camera);
    RMAP_TRY(rmap_load_accel(session->context, session->scene, NULL, &session->accel, err));
    st = rmap_renderer_create(session->scene, session->accel, session->camera, request->size,
                              request->seed, &session->renderer, err);
    if (st == RMAP_OK)
        session->renderer->clamp = request->clamp;
    session->rgb = rmap_alloc((size_t)request->size[0] * request->size[1], 3 * sizeof(float));
    session->lit = rmap_alloc((size_t)request->size[0] * request->size[1], 1);
    if (st == RMAP_OK && (!session->rgb || !session->lit))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    RMAP_TRY(rmap_agree(session->context, st, err));
out:
    return st;
}

static const char *unit_of(const struct rmap_scene *scene)
{
    return rmap_image_unit_usual(RMAP_PER_AREA_AND_ANGLE, scene->flux_unit)->name;
}

/* On rank 0, after each pass. */
static enum rmap_status show(void *self, const struct rmap_film *film, struct rmap_error *err)
{
    struct session *session = self;
    const struct request *request = &session->request;
    enum rmap_status st = RMAP_OK;
    char comment[200];
    session->shown = true;
    rmap_film_resolve(film, session->rgb);
    session->exposure = request->exposure > 0.0 ? request->exposure : session->camera->exposure;
    if (!(session->exposure > 0.0)) {
        rmap_film_lit(film, session->lit);
        RMAP_TRY(rmap_photo_expose(session->rgb, session->lit,
                                   (size_t)film->size[0] * film->size[1], &session->exposure, err));
    }
    (void)snprintf(comment, sizeof comment, "raymap: camera %.80s, %llu samples, luminance in %s%s",
                   session->camera->name, (unsigned long long)film->n_sample,
                   unit_of(session->scene), request->clamp > 0.0 ? ", clamped" : "");
    const struct rmap_photo photo = {.size = {film->size[0], film->size[1]},
                                     .rgb = session->rgb,
                                     .exposure = session->exposure,
                                     .comment = comment};
    for (size_t i = 0; i < request->n_output; i++)
        RMAP_TRY(rmap_photo_write(&photo, request->output[i], err));
out:
    return st;
}

/* ---- what came of it ---- */

static json_t *report_json(const struct session *session)
{
    const struct rmap_render_run *run = &session->run;
    const struct rmap_render_counts *counts = &run->counts;
    const struct rmap_film *film = run->film;
    double noise = 0.0, mean = 0.0;
    json_t *outputs = json_array();
    for (size_t i = 0; i < session->request.n_output; i++)
        (void)json_array_append_new(outputs, json_string(session->request.output[i]));
    rmap_film_noise(film, &noise, &mean);
    json_t *document = json_pack(
        "{s:o, s:s, s:[I,I], s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:f, s:f, s:o, s:f, s:s, s:i, "
        "s:i}",
        "output", outputs, "camera", session->camera->name, "size", (json_int_t)film->size[0],
        (json_int_t)film->size[1], "samples", (json_int_t)film->n_sample, "paths",
        (json_int_t)counts->n_path, "legs", (json_int_t)counts->n_segment, "looks",
        (json_int_t)counts->n_look, "limits", (json_int_t)counts->n_limit, "errors",
        (json_int_t)counts->n_error, "seconds", run->seconds, "frames_per_second",
        (double)film->n_sample / run->seconds, "mean", mean, "noise", rmap_json_number(noise),
        "exposure", session->exposure, "unit", unit_of(session->scene), "ranks",
        session->context->size, "threads", run->n_thread);
    if (document && session->request.clamp > 0.0)
        (void)json_object_set_new(document, "clamp",
                                  json_pack("{s:f, s:f}", "luminance", session->request.clamp,
                                            "cut", rmap_film_cut(film)));
    return document;
}

/* Of the light that there would be without the clamp. */
static double cut_share(const struct rmap_film *film, double mean)
{
    const double cut = rmap_film_cut(film);
    return cut > 0.0 ? cut / (mean + cut) : 0.0;
}

static void report_print(const struct session *session)
{
    const struct rmap_render_counts *counts = &session->run.counts;
    const struct rmap_film *film = session->run.film;
    double noise = 0.0, mean = 0.0, seconds = session->run.seconds;
    rmap_film_noise(film, &noise, &mean);
    printf("camera %s, %u x %u, %s: %s, %s, %s at lights\n", session->camera->name, film->size[0],
           film->size[1], rmap_counted(film->n_sample, "sample").text,
           rmap_counted(counts->n_path, "path").text, rmap_counted(counts->n_segment, "leg").text,
           rmap_counted(counts->n_look, "look").text);
    printf("%.2f s, %.3g M paths/s, %.3g pictures of one sample a second\n", seconds,
           1e-6 * (double)counts->n_path / seconds, (double)film->n_sample / seconds);
    printf("mean luminance %.4g %s", mean, unit_of(session->scene));
    if (film->n_sample > 1)
        printf(", standard error of a pixel %.3g", noise);
    printf("; exposure %.4g\n", session->exposure);
    if (session->request.clamp > 0.0)
        printf("clamp took %.3g %s of it away, %.2g %% of the light\n", rmap_film_cut(film),
               unit_of(session->scene), 100.0 * cut_share(film, mean));
    for (size_t i = 0; i < session->request.n_output; i++)
        printf("%s\n", session->request.output[i]);
}

/* On rank 0. */
static void remark(const struct session *session)
{
    const struct rmap_render_counts *counts = &session->run.counts;
    const struct rmap_film *film = session->run.film;
    double noise, mean;
    const struct rmap_lights *lights = session->renderer->lights;
    if (session->context->quiet)
        return;
    if (lights->n_unseen > 0)
        fprintf(stderr, "raymap: %zu source%s of single rays cannot be seen by a camera\n",
                lights->n_unseen, lights->n_unseen > 1 ? "s" : "");
    rmap_film_noise(film, &noise, &mean);
    if (film->n_sample >= DOTS_SAMPLES && noise > DOTS_NOISE * mean &&
        !(session->request.clamp > 0.0))
        fprintf(stderr,
                "raymap: few bright paths make this noise, bright dots in the picture: more "
                "--samples, or --clamp %g\n",
                rmap_round_below(DOTS_CLAMP * mean));
    if (counts->n_error > 0)
        fprintf(stderr,
                "raymap: %llu of %s ended with an error; raymap check says where media do "
                "not match\n",
                (unsigned long long)counts->n_error, rmap_counted(counts->n_path, "path").text);
    if (counts->n_limit > 0)
        fprintf(stderr, "raymap: %llu of %s ended at a limit\n",
                (unsigned long long)counts->n_limit, rmap_counted(counts->n_path, "path").text);
}

/* On rank 0. Early is what had less than was asked for. */
static enum rmap_status conclude(const struct session *session, struct rmap_error *err)
{
    const struct request *request = &session->request;
    enum rmap_status st = RMAP_OK;
    uint64_t n = session->run.n_done;
    if (n > 0) {
        remark(session);
        if (session->context->json)
            RMAP_TRY(rmap_json_print(report_json(session), stdout, err));
        else if (!session->context->quiet)
            report_print(session);
    }
    if (session->run.interrupt)
        st = rmap_error_set(err, RMAP_STOPPED, "stopped by %s after %llu of %s",
                            rmap_interrupt_name(session->run.interrupt), (unsigned long long)n,
                            rmap_counted(request->n_sample, "sample").text);
    else if (n < request->n_sample && request->has_samples)
        st = rmap_error_set(err, RMAP_STOPPED, "stopped by the time limit after %llu of %s",
                            (unsigned long long)n, rmap_counted(request->n_sample, "sample").text);
out:
    return st;
}

static void request_fini(struct request *request)
{
    rmap_argument_list_free(request->output, request->n_output);
    rmap_scene_options_fini(&request->scene);
    *request = (struct request){0};
}

static void destroy(void *state)
{
    struct session *session = state;
    rmap_render_end(&session->run);
    request_fini(&session->request);
    rmap_free(session->rgb);
    rmap_free(session->lit);
    rmap_renderer_destroy(session->renderer);
    rmap_accel_destroy(session->accel);
    rmap_scene_destroy(session->scene);
    rmap_bundle_destroy(session->bundle);
    rmap_free(session);
}

/* Collective. A new session, or the one of the run before. Takes the request over. */
static enum rmap_status begin(const struct rmap_context *context, struct request *request,
                              struct session **session_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct session *session = *session_ret;
    const bool goes_on = session != NULL;
    if (!goes_on && !(session = *session_ret = rmap_alloc(1, sizeof *session)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    RMAP_TRY(rmap_agree(context, st, err));
    session->context = context;
    session->request = *request;
    *request = (struct request){0};
    if (goes_on)
        return RMAP_OK;
    RMAP_TRY(prepare(session, err));
    const struct rmap_render_plan plan = {.renderer = session->renderer,
                                          .n_sample = session->request.n_sample,
                                          .time_limit_s = session->request.time_limit_s,
                                          .show = show,
                                          .self = session};
    RMAP_TRY(rmap_render_begin(context, &plan, &session->run, err));
out:
    return st;
}

/* Collective. */
static enum rmap_status go_on(struct session *session, double seconds, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    session->shown = false;
    RMAP_TRY(rmap_render_step(&session->run, seconds, err));
    if (session->context->rank == 0 && session->run.is_over)
        st = conclude(session, err);
    else if (session->shown)
        st = rmap_json_print(report_json(session), stdout, err);
    RMAP_TRY(rmap_agree(session->context, st, err));
out:
    return st;
}

static enum rmap_status run_render(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_at_hand_steps *steps = context->at_hand ? context->at_hand->steps : NULL;
    struct session *session = steps ? steps->state : NULL;
    struct request request;
    if (steps)
        steps->state = NULL; /* unless there is more to do */
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(begin(context, &request, &session, err));
    RMAP_TRY(go_on(session, steps ? steps->seconds : 0.0, err));
    if (steps && !session->run.is_over) {
        request_fini(&session->request); /* what it points to is gone by the next run */
        steps->state = session;
        steps->destroy = destroy;
        session = NULL;
    }
out:
    request_fini(&request);
    if (session)
        destroy(session);
    return st;
}

const struct rmap_command rmap_command_render = {
    .name = "render",
    .summary = "a picture of the scene as a camera of it sees it",
    .operands = "SCENE [--camera NAME] -o OUT.png [-o OUT.exr]",
    .help = "Traces light backward from a camera of the scene to its sources, through lenses,\n"
            "mirrors and gradient media, as\n\n"
            "  raymap render scene.yaml --camera front --samples 256 -o a.png -o a.exr\n\n"
            "The picture is rewritten after each pass, so it can be watched as it gets clearer.\n"
            "OUT.exr holds linear RGB whose luminance is in cd/m2, or in W/(m2 sr) where sources\n"
            "are given in W. Any number of ranks and threads gives the same picture. A point or a\n"
            "collimated source lights what it reaches straight; its light through glass or by a\n"
            "mirror is the business of raymap trace. --samples not reached in time: status 6.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .stops_in_order = true,
    .run = run_render,
};
