/* SPDX-License-Identifier: MIT
 *
 * raymap sweep: a scene with other values of its keys, variant by variant, and what is asked of
 * each.
 */
#include <stdio.h>
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/sweep/sweep_figure.h"
#include "base/alloc.h"
#include "io/export/raster.h"
#include "io/file/publish.h"
#include "io/file/text_file.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/sweep/sweep_answers.h"
#include "mpi/sweep/sweep_run.h"

static const struct rmap_option options[] = {
    {"output", 'o', "FOLDER", "of the results (default: SWEEP without its suffix, and .sweep)"},
    {"resume", 0, NULL, "go on with the variants that FOLDER lacks"},
    {"plot", 0, "PLOT", "the picture of the answers, .svg or .png (plot.svg is in FOLDER)"},
    {"force", 'f', NULL, "begin anew where FOLDER holds a sweep; replace PLOT"},
    {"set", 0, "KEY=VALUE", "another value for a key of the scene, in all variants"},
    {"allow-plugins", 0, NULL, "run the code of plug-ins that the scene names"},
    RMAP_CACHE_OPTION,
    {NULL}};

static const struct rmap_text_kind sweep_file = {"a file of a sweep", "YAML text", "",
                                                 (size_t)16 << 20};

/* Collective. */
static enum rmap_status load_sweep(const struct rmap_context *context, const char *path,
                                   struct rmap_sweep **sweep, struct rmap_error *err)
{
    struct rmap_diagnostics diagnostics;
    uint8_t *blob = NULL;
    char *text = NULL;
    size_t nbytes = 0;
    enum rmap_status st = RMAP_OK;
    rmap_diagnostics_init(&diagnostics, path);
    if (context->rank == 0)
        st = rmap_text_file_read(path, &sweep_file, &text, &nbytes, err);
    RMAP_TRY(rmap_agree(context, st, err));
    nbytes++; /* its 0, too */
    blob = (uint8_t *)text;
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    st = rmap_sweep_read(path, (const char *)blob, nbytes - 1, &diagnostics, sweep, err);
    if (context->rank == 0 && (st != RMAP_OK || !context->quiet))
        rmap_diagnostics_print(&diagnostics, stderr);
    st = rmap_agree(context, st, err);
out:
    rmap_free(blob);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}

/* Beside the sweep's file. */
static char *scene_beside(const char *path, const char *scene)
{
    const char *slash = strrchr(path, '/');
    return scene[0] == '/' || !slash
               ? rmap_strdup(scene)
               : rmap_path_format("%.*s/%s", (int)(slash - path), path, scene);
}

static char *folder_of(const char *path, const char *given)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const size_t len =
        dot && (!slash || dot > slash + 1) && dot != path ? (size_t)(dot - path) : strlen(path);
    return given ? rmap_strdup(given) : rmap_path_format("%.*s.sweep", (int)len, path);
}

/* Collective. The scene as it is, and what it has at the parameters' keys. */
static enum rmap_status load_nominal(const struct rmap_context *context,
                                     const struct rmap_arguments *given, struct rmap_sweep_run *run,
                                     struct rmap_error *err)
{
    struct rmap_scene_options scene_options = {.set = NULL};
    struct rmap_scene *scene = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_sweep *sweep = run->sweep;
    rmap_diagnostics_init(&diagnostics, sweep->path);
    enum rmap_status st = rmap_scene_options_read(given, &scene_options, err);
    if (st == RMAP_OK && sweep->simulation &&
        !(scene_options.simulation = rmap_strdup(sweep->simulation)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, run->scene_path, &scene_options, &run->bundle, &scene, err));
    if (sweep->n_ray == 0)
        sweep->n_ray = scene->simulation.rays;
    if (sweep->n_ray == 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s: 'rays: N' says how many rays a variant has",
                            sweep->path);
    if (st == RMAP_OK)
        st = rmap_sweep_find_nominal(sweep, run->bundle, &diagnostics, err);
    if (st == RMAP_OK)
        st = rmap_sweep_check(sweep, scene, err);
    if (context->rank == 0)
        rmap_diagnostics_print(&diagnostics, stderr);
    st = rmap_agree(context, st, err);
out:
    rmap_scene_destroy(scene);
    rmap_diagnostics_fini(&diagnostics);
    return st;
}

static enum rmap_status draw(const struct rmap_sweep_run *run, const char *path,
                             struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    enum rmap_status st = rmap_figure_sweep(&run->table, &svg, err);
    if (st == RMAP_OK)
        st = rmap_picture_write(svg, path, RMAP_FIGURE_SCALE, err);
    rmap_svg_destroy(svg);
    return st;
}

/* New reference; NULL when memory is short. */
static json_t *document_of(const struct rmap_sweep_run *run)
{
    json_t *document = rmap_sweep_table_json(&run->table);
    const struct rmap_sweep_times *times = &run->times;
    if (document)
        (void)json_object_set_new(document, "seconds",
                                  json_pack("{s:f, s:f, s:f, s:f, s:f}", "all", times->all,
                                            "scenes", times->scenes, "trees", times->trees,
                                            "tracing", times->tracing, "answers", times->answers));
    if (document)
        (void)json_object_set_new(document, "rays_taken_over",
                                  json_integer((json_int_t)run->n_reused));
    return document;
}

/* Rank 0. */
static enum rmap_status show(const struct rmap_sweep_run *run, const char *plot,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *csv = rmap_path_format("%s/table.csv", run->folder);
    char *h5 = rmap_path_format("%s/table.h5", run->folder);
    char *picture = rmap_path_format("%s/plot.svg", run->folder);
    if (!csv || !h5 || !picture)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path"));
    RMAP_TRY(rmap_sweep_table_csv(&run->table, csv, err));
    RMAP_TRY(rmap_sweep_table_h5(&run->table, h5, err));
    RMAP_TRY(draw(run, picture, err));
    if (plot)
        RMAP_TRY(draw(run, plot, err));
    if (run->context->json)
        st = rmap_json_print(document_of(run), stdout, err);
    else
        st = rmap_sweep_table_print(&run->table, stdout, err);
    if (!run->context->quiet)
        fprintf(stderr, "%s: %.1f s, %.1f %% of them in tracing\n", run->folder, run->times.all,
                run->times.all > 0.0 ? 100.0 * run->times.tracing / run->times.all : 0.0);
out:
    rmap_free(picture);
    rmap_free(csv);
    rmap_free(h5);
    return st;
}

static enum rmap_status run_sweep(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_sweep_run run = {.context = context,
                                 .is_resumed = rmap_argument(given, "resume") != NULL,
                                 .is_forced = rmap_argument(given, "force") != NULL};
    const char *path = given->operand[0];
    const char *plot = rmap_argument(given, "plot");
    char *folder = NULL, *scene_path = NULL;
    static const char *const suffixes[] = {".svg", ".png", NULL};
    enum rmap_status st = RMAP_OK;
    if (run.is_resumed && run.is_forced)
        return rmap_error_set(err, RMAP_USAGE,
                              "--resume goes on with what --force takes away: give one of them");
    if (context->rank == 0 && plot)
        st = rmap_output_check(plot, suffixes, run.is_forced || run.is_resumed, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(load_sweep(context, path, &run.sweep, err));
    run.folder = folder = folder_of(path, rmap_argument(given, "output"));
    run.scene_path = scene_path = scene_beside(path, run.sweep->scene_path);
    if (!folder || !scene_path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path");
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(load_nominal(context, given, &run, err));
    RMAP_TRY(rmap_sweep_run(&run, err));
    if (context->rank == 0)
        st = show(&run, plot, err);
    st = rmap_agree(context, st, err);
out:
    rmap_map_lock_release(&run.lock);
    rmap_sweep_table_fini(&run.table);
    rmap_bundle_destroy(run.bundle);
    rmap_sweep_destroy(run.sweep);
    rmap_free(scene_path);
    rmap_free(folder);
    return st;
}

const struct rmap_command rmap_command_sweep = {
    .name = "sweep",
    .summary = "a scene with other values of its keys, and what they change",
    .operands = "SWEEP [-o FOLDER] [--resume]",
    .help =
        "Traces a scene with other values of some of its keys, variant by variant, as a file "
        "says:\n\n"
        "  scene: scene.yaml\n"
        "  rays: 20000\n"
        "  parameters:\n"
        "    defocus: {key: objects.sensor.at.3, plus: true, values: [-0.1, 0.1]}\n"
        "  answers:\n"
        "    spot: {detector: sensor, of: rms_radius}\n\n"
        "or with tolerances: {distribution: {normal: {sigma: 0.05}}}, `samples: 200` and\n"
        "`require: spot < 0.02`. FOLDER gets a table of the variants and their answers with "
        "standard\n"
        "errors, table.csv and table.h5. All variants have the same rays. Under mpirun groups of\n"
        "ranks take variants in turn; the numbers are the same for any number of ranks and "
        "threads.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .stops_in_order = true,
    .run = run_sweep,
};
