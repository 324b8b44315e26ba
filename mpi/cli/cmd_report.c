/* SPDX-License-Identifier: MIT
 *
 * raymap report: everything that happened along one ray, from a map or traced again; or where the
 * light of a whole map went.
 */
#include <sys/stat.h>

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "accel/accel.h"
#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/answer/report_page.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/asked.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/energy_run.h"
#include "mpi/scan/head_reads.h"
#include "mpi/scan/ray_lines.h"
#include "trace/tracer.h"

static const struct rmap_option options[] = {
    {"energy", 'e', NULL, "of a MAP: where the light of each source went, exactly"},
    {"html", 0, NULL, "of a MAP: a page about all of it, for a browser"},
    {"sample", 0, "N", "with --html: paths from the first N rays, for maps too large to read"},
    {"where", 'w', "CRITERION", "with --energy or --html: of the rays that match only"},
    RMAP_ASKED_OPTIONS,
    {"output", 'o', "OUT",
     "of rays: OUT.csv, a row per segment; --energy: OUT.csv, OUT.json, OUT.svg or OUT.png; "
     "--html: OUT.html"},
    {"force", 'f', NULL, "replace OUT", "output html"},
    {"ray", 'r', "N", "trace ray N of a SCENE and print it with all digits"},
    {"rays", 0, "A..B", "the same of all rays from A to B; with --json one list of them"},
    {"seed", 's', "S", "of the random numbers (default 1), with --ray or --rays", "ray rays"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

/* The file of --output, for rows of rays of the scene; none without that option. */
static enum rmap_status open_csv(const struct rmap_arguments *given, const struct rmap_scene *scene,
                                 struct rmap_whole_file *csv, struct rmap_error *err)
{
    static const char *const suffix[] = {".csv", NULL};
    enum rmap_status st = RMAP_OK;
    const char *path = rmap_argument(given, "output");
    if (!path)
        return RMAP_OK;
    RMAP_TRY(rmap_output_check(path, suffix, rmap_argument(given, "force") != NULL, err));
    RMAP_TRY(rmap_whole_file_open(csv, path, err));
    fputs(rmap_ray_csv_header(scene), csv->file);
out:
    return st;
}

static enum rmap_status close_csv(struct rmap_whole_file *csv, struct rmap_error *err)
{
    return csv->file ? rmap_whole_file_finish(csv, err) : RMAP_OK;
}

/* map: that it was read from, or NULL; csv: where to in place of standard output, or NULL. */
static enum rmap_status print_report(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_ray_report *report, FILE *csv,
                                     struct rmap_error *err)
{
    if (csv)
        return rmap_ray_csv_write(report, csv, err);
    json_t *document = context->json ? rmap_ray_report_json(report) : NULL;
    if (context->json)
        return rmap_json_print(map ? rmap_json_of_map(document, map) : document, stdout, err);
    return rmap_ray_report_print(report, stdout, err);
}

/* Collective. */
static enum rmap_status report_map(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_ray_report *report = NULL;
    struct rmap_head_reads *reads = NULL;
    struct rmap_whole_file csv = {0};
    uint64_t ray = 0;
    enum rmap_status st = rmap_parse_count(given->operand[1], "the ray", &ray, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_map(context, given->operand[0], &map, err));
    RMAP_TRY(rmap_head_reads_begin(context, map, &reads, err));
    if (context->rank == 0) {
        st = rmap_ray_report_read(map, ray, &report, err);
        rmap_head_reads_end(reads);
        if (st == RMAP_OK)
            st = open_csv(given, rmap_map_scene(map), &csv, err);
        if (st == RMAP_OK)
            st = print_report(context, map, report, csv.file, err);
        if (st == RMAP_OK)
            st = close_csv(&csv, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_whole_file_fini(&csv);
    rmap_ray_report_destroy(report);
    rmap_map_close(map);
    return st;
}

/* Rays to trace again: from first to last; a list even of one, when asked for as a range. */
struct range {
    uint64_t first, last;
    bool is_list;
};

static enum rmap_status read_range(const struct rmap_arguments *given, struct range *range,
                                   struct rmap_error *err)
{
    const char *text = rmap_argument(given, "rays"), *dots = text ? strstr(text, "..") : NULL;
    char first[32];
    enum rmap_status st = RMAP_OK;
    *range = (struct range){.is_list = text != NULL};
    if (!text) {
        RMAP_TRY(rmap_argument_count(given, "ray", &range->first, err));
        range->last = range->first;
        goto out;
    }
    if (!dots || (size_t)(dots - text) >= sizeof first)
        return rmap_error_set(err, RMAP_USAGE, "--rays takes a range as 0..99, not '%s'", text);
    snprintf(first, sizeof first, "%.*s", (int)(dots - text), text);
    RMAP_TRY(rmap_parse_count(first, "--rays", &range->first, err));
    RMAP_TRY(rmap_parse_count(dots + 2, "--rays", &range->last, err));
    if (range->last < range->first)
        st = rmap_error_set(err, RMAP_USAGE, "--rays %s ends before it begins", text);
out:
    return st;
}

static enum rmap_status put(const char *text, struct rmap_error *err)
{
    return fputs(text, stdout) == EOF
               ? rmap_error_set(err, RMAP_SYSTEM, "cannot write the reports: the output failed")
               : RMAP_OK;
}

/* A list has one ray a line, so that its memory is that of one. */
static enum rmap_status print_next(const struct rmap_context *context, const struct range *range,
                                   const struct rmap_ray_report *report, FILE *csv,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool is_first = report->ray == range->first;
    if (!context->json || !range->is_list || csv) {
        if (!is_first && !csv)
            RMAP_TRY(put("\n", err));
        return print_report(context, NULL, report, csv, err);
    }
    RMAP_TRY(put(is_first ? "[" : ",", err));
    RMAP_TRY(rmap_json_line(rmap_ray_report_json(report), stdout, err));
    if (report->ray == range->last)
        st = put("]\n", err);
out:
    return st;
}

/* Not collective. */
static enum rmap_status trace_and_print(const struct rmap_context *context,
                                        const struct rmap_scene *scene, const struct range *range,
                                        uint64_t seed, FILE *csv, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_accel *accel = NULL;
    struct rmap_ray_report *report = NULL;
    struct rmap_history history;
    rmap_history_init(&history, scene->channels.n);
    if (scene->n_source == 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "the scene has no source of light"));
    RMAP_TRY(rmap_accel_create(scene, context->n_thread, &accel, err));
    struct rmap_tracer tracer = {.scene = scene, .accel = accel, .seed = seed};
    for (uint64_t n = 0; n <= range->last - range->first; n++) {
        rmap_trace_ray(&tracer, range->first + n, &history.base);
        RMAP_TRY(rmap_ray_report_trace(scene, &history, &report, err));
        RMAP_TRY(print_next(context, range, report, csv, err));
        rmap_ray_report_destroy(report);
        report = NULL;
    }
out:
    rmap_ray_report_destroy(report);
    rmap_history_fini(&history);
    rmap_accel_destroy(accel);
    return st;
}

static enum rmap_status check_is_scene(const struct rmap_arguments *given,
                                       const struct range *range, struct rmap_error *err)
{
    const char *path = given->operand[0];
    struct stat status;
    if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s is a directory, and --%s traces again what a scene file says; of a "
                          "map: raymap report %s %" PRIu64,
                          path, range->is_list ? "rays" : "ray", path, range->first);
}

/* Collective. */
static enum rmap_status report_scene(const struct rmap_context *context,
                                     const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene *scene = NULL;
    struct rmap_scene_options options_given = {0};
    struct rmap_whole_file csv = {0};
    struct range range;
    uint64_t seed = 1;
    enum rmap_status st = read_range(given, &range, err);
    if (st == RMAP_OK)
        st = check_is_scene(given, &range, err);
    if (st == RMAP_OK)
        st = rmap_argument_count(given, "seed", &seed, err);
    if (st == RMAP_OK)
        st = rmap_scene_options_read(given, &options_given, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, given->operand[0], &options_given, &bundle, &scene, err));
    scene->seed = seed;
    if (context->rank == 0) {
        st = open_csv(given, scene, &csv, err);
        if (st == RMAP_OK)
            st = trace_and_print(context, scene, &range, seed, csv.file, err);
        if (st == RMAP_OK)
            st = close_csv(&csv, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_whole_file_fini(&csv);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(bundle);
    rmap_scene_options_fini(&options_given);
    return st;
}

/* Options that say nothing about one ray. */
static const char *const of_energy[] = {"where", "criteria", "zemax"}, *const of_page = "sample";

static enum rmap_status run_report(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    const bool range = rmap_argument(given, "rays") != NULL;
    const bool scene = range || rmap_argument(given, "ray") != NULL;
    const bool energy = rmap_argument(given, "energy") != NULL;
    const bool html = rmap_argument(given, "html") != NULL;
    if (range && rmap_argument(given, "ray"))
        return rmap_error_set(err, RMAP_USAGE, "say --ray or --rays");
    if (energy && html)
        return rmap_error_set(err, RMAP_USAGE, "say --energy or --html; the page has the energy");
    if ((energy || html) && (scene || (energy && given->n_operand != 1)))
        return rmap_error_set(err, RMAP_USAGE, "--%s goes with a MAP alone, without a ray",
                              energy ? "energy" : "html");
    for (size_t i = 0; i < sizeof of_energy / sizeof *of_energy && !energy && !html; i++)
        if (rmap_argument(given, of_energy[i]))
            return rmap_error_set(err, RMAP_USAGE, "--%s goes with --energy or --html",
                                  of_energy[i]);
    if (html && rmap_argument(given, of_page) && rmap_argument(given, "where"))
        return rmap_error_set(err, RMAP_USAGE, "--where reads all rays: leave --%s out", of_page);
    if (!html && rmap_argument(given, of_page))
        return rmap_error_set(err, RMAP_USAGE, "--%s goes with --html", of_page);
    if (energy)
        return rmap_report_energy(context, given, err);
    if (html)
        return rmap_report_page(context, given, err);
    if (scene && given->n_operand == 1)
        return report_scene(context, given, err);
    if (!scene && given->n_operand == 2)
        return report_map(context, given, err);
    return rmap_error_set(
        err, RMAP_USAGE,
        "say either a MAP and a RAY, a SCENE and --ray N or --rays A..B, or a MAP and --energy "
        "or --html; see: raymap report --help");
}

const struct rmap_command rmap_command_report = {
    .name = "report",
    .summary = "all that happened along a ray; a whole map's energy, or a page",
    .operands = "MAP RAY | SCENE --ray N | SCENE --rays A..B | MAP --energy | MAP --html",
    .help =
        "Prints a ray's history, segment by segment: the object met, what happened there, the "
        "medium\n"
        "travelled, position, direction, colour, and the detectors that registered it.\n\n"
        "From a MAP positions have the 9 digits that are stored. From a SCENE the ray is\n"
        "traced again and printed with 17 digits; its flux is then what it would carry as its\n"
        "source's only ray. Steps and rays count from 0. --rays A..B prints those from A to B,\n"
        "with --json as one list, written while they are traced.\n\n"
        "With --energy: emitted = absorbed by each object and in each medium + left the scene\n"
        "+ stopped by limits and errors, per source and in all, in rays (exact) and in flux\n"
        "with its standard error; beside it what each detector registered. As\n\n"
        "  raymap report lens.raymap --energy --where 'hit(*, reflect) >= 2' -o flow.png\n\n"
        "With --html: one page without scripts that a mail can carry: the scene with rays,\n"
        "where the light went, every detector's image, the paths that carried most, and where\n"
        "the map comes from. To standard output, or as\n\n"
        "  raymap report lens.raymap --html lens.html",
    .options = options,
    .min_operands = 1,
    .max_operands = 2,
    .run = run_report,
};
