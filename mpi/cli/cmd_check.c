/* SPDX-License-Identifier: MIT
 *
 * raymap check: what is in a scene, and everything that is wrong with it.
 */
#include <stdio.h>

#include "accel/accel.h"
#include "base/clock.h"
#include "base/grouped.h"
#include "mpi/answer/lamp_sheet_out.h"
#include "mpi/answer/scene_between.h"
#include "mpi/answer/scene_schema.h"
#include "mpi/answer/scene_summary.h"
#include "mpi/answer/surface_out.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/command/scene_check.h"
#include "mpi/parallel/agree.h"

static const struct rmap_option options[] = {
    {"seed", 's', "S", "of the probing rays (default 1)"},
    {"surface", 0, "NAME", "show what a surface makes of light, over angle and wavelength"},
    {"plot", 0, "OUT", "draw that: .svg or .png", "surface"},
    {"force", 'f', NULL, "replace OUT", "plot"},
    {"lamp", 0, "NAME",
     "a lamp's data sheet: intensities at C-planes and gammas, cd/klm, beam and field angle, and "
     "its "
     "table of glare (UGR)"},
    RMAP_LAMP_SHEET_OPTIONS("lamp"),
    {"schema", 0, NULL,
     "print the JSON Schema of scene files, by which editors complete their keys"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

static const char *const pictures[] = {".svg", ".png", NULL};

struct checked {
    const char *path, *surface, *plot, *lamp;
    struct rmap_lamp_sheet_ask sheet;
    struct rmap_bundle *bundle;
    struct rmap_scene *scene; /* borrowed of `found` */
    struct rmap_diagnostics diagnostics;
    struct rmap_scene_checked found;
};

static json_t *times_json(const struct checked *checked)
{
    const struct rmap_accel_build *build = &checked->found.build;
    return json_pack("{s:f, s:I, s:f, s:I, s:f}", "read_seconds", checked->found.read_s, "meshes",
                     (json_int_t)build->n_built, "meshes_seconds", build->meshes_s, "objects",
                     (json_int_t)build->n_object, "top_seconds", build->top_s);
}

/* How long a start takes, by levels. */
static void print_times(const struct checked *checked)
{
    const struct rmap_accel_build *build = &checked->found.build;
    printf("  times      read in %.3g s, %s built in %.3g s, top level of %s in %.3g s\n",
           checked->found.read_s, rmap_counted(build->n_built, "mesh").text, build->meshes_s,
           rmap_counted(build->n_object, "object").text, build->top_s);
}

static enum rmap_status print_result(const struct rmap_context *context,
                                     const struct checked *checked,
                                     const struct rmap_surface_question *asked,
                                     const struct rmap_source *lamp, struct rmap_error *err)
{
    if (!context->at_hand) /* whose answer has them */
        rmap_diagnostics_print(&checked->diagnostics, stderr);
    if (context->json) {
        json_t *document = json_pack("{s:s, s:I, s:o}", "path", checked->path, "errors",
                                     (json_int_t)checked->diagnostics.n_error, "diagnostics",
                                     rmap_json_diagnostics(&checked->diagnostics));
        const struct rmap_mismatch_effort *effort = &checked->found.effort;
        (void)json_object_set_new(document, "probing",
                                  json_pack("{s:I, s:I, s:b}", "rays", (json_int_t)effort->n_sent,
                                            "wanted", (json_int_t)effort->n_ray, "cut",
                                            (int)effort->cut));
        if (checked->found.build.n_object)
            (void)json_object_set_new(document, "times", times_json(checked));
        if (checked->scene)
            (void)json_object_set_new(document, "scene", rmap_scene_summary_json(checked->scene));
        if (asked)
            (void)json_object_set_new(document, "surface", rmap_surface_json(asked));
        if (lamp)
            (void)json_object_set_new(document, "lamp",
                                      rmap_lamp_out_json(checked->scene, lamp, &checked->sheet));
        return rmap_json_print(document, stdout, err);
    }
    if (checked->scene && !context->quiet) {
        printf("%s\n", checked->path);
        rmap_scene_summary_print(checked->scene, stdout);
        if (checked->found.build.n_object)
            print_times(checked);
    }
    if (asked)
        rmap_surface_print(asked, stdout);
    return lamp ? rmap_lamp_out_print(checked->scene, lamp, &checked->sheet, stdout, err) : RMAP_OK;
}

/* n_warning: of the reading of the scene. */
static enum rmap_status draw(const struct checked *checked, size_t n_warning,
                             const struct rmap_surface_question *asked, struct rmap_error *err)
{
    struct rmap_scene *between =
        rmap_scene_between(checked->bundle, checked->scene, checked->surface, n_warning);
    enum rmap_status st = rmap_surface_draw(asked, between, checked->plot, err);
    rmap_scene_destroy(between);
    return st;
}

/* Rank 0 does it all: files are read once. */
static enum rmap_status check_scene(const struct rmap_context *context,
                                    struct rmap_scene_options *options_given, uint64_t seed,
                                    struct checked *checked, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_surface_question question, *asked = NULL;
    const struct rmap_source *lamp = NULL;
    const double begun = rmap_clock_seconds();
    RMAP_TRY(rmap_load_bundle(context, checked->path, options_given, &checked->bundle, err));
    checked->found.read_s = rmap_clock_seconds() - begun;
    st = rmap_scene_check(checked->bundle, context->n_thread, seed, &checked->diagnostics,
                          &checked->found, err);
    checked->scene = checked->found.scene;
    if (st != RMAP_OK && (st != RMAP_INPUT || checked->diagnostics.n_error == 0))
        goto out;
    if (st == RMAP_OK && checked->surface) {
        RMAP_TRY(rmap_surface_ask(checked->scene, checked->surface, &question, err));
        asked = &question;
    }
    if (st == RMAP_OK && checked->lamp)
        RMAP_TRY(rmap_find_lamp(checked->scene, checked->path, checked->lamp, &lamp, err));
    if (asked && checked->plot)
        RMAP_TRY(draw(checked, checked->found.n_read, asked, err));
    RMAP_TRY(print_result(context, checked, asked, lamp, err));
    if (checked->diagnostics.n_error > 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s: %zu error%s", checked->path,
                            checked->diagnostics.n_error,
                            checked->diagnostics.n_error > 1 ? "s" : "");
out:
    return st;
}

static enum rmap_status print_schema(struct rmap_error *err)
{
    json_t *schema = rmap_scene_schema();
    int failed = json_dumpf(schema, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(15));
    json_decref(schema);
    if (failed || printf("\n") < 0)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write the schema of scene files");
    return RMAP_OK;
}

static enum rmap_status run_check(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    uint64_t seed = 1;
    struct rmap_scene_options scene_options = {0};
    struct checked checked = {.path = given->operand[0],
                              .surface = rmap_argument(given, "surface"),
                              .plot = rmap_argument(given, "plot"),
                              .lamp = rmap_argument(given, "lamp")};
    rmap_diagnostics_init(&checked.diagnostics, checked.path);
    enum rmap_status st = RMAP_OK;
    const bool schema = rmap_argument(given, "schema") != NULL;
    if (schema != !checked.path)
        st = rmap_error_set(err, RMAP_USAGE, "%s; usage: raymap check %s\nsee: raymap check --help",
                            schema ? "--schema takes no SCENE" : "SCENE is missing",
                            rmap_command_check.operands);
    else if (schema && context->rank == 0)
        st = print_schema(err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (schema)
        goto out;
    if (checked.plot)
        st = rmap_output_check(checked.plot, pictures, rmap_argument(given, "force") != NULL, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_argument_count(given, "seed", &seed, err);
    if (st == RMAP_OK)
        st = rmap_scene_options_read(given, &scene_options, err);
    if (st == RMAP_OK)
        st = rmap_lamp_sheet_ask(given, &checked.sheet, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank == 0)
        st = check_scene(context, &scene_options, seed, &checked, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_diagnostics_fini(&checked.diagnostics);
    rmap_scene_options_fini(&scene_options);
    rmap_lamp_sheet_ask_fini(&checked.sheet);
    rmap_scene_checked_fini(&checked.found);
    rmap_bundle_destroy(checked.bundle);
    return st;
}

const struct rmap_command rmap_command_check = {
    .name = "check",
    .summary = "say what is in a scene and everything that is wrong with it",
    .operands = "SCENE | --schema",
    .help = "Reads a scene with all its files, lists every mistake with file:line:column and the\n"
            "remedy, and sends some thousand rays through it to find touching surfaces whose\n"
            "media do not match. Exit status 3 when there is an error. --surface shows what a\n"
            "surface reflects, transmits and absorbs over angle and wavelength, --plot draws it.",
    .options = options,
    .min_operands = 0,
    .max_operands = 1,
    .run = run_check,
};
