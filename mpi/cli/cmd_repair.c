/* SPDX-License-Identifier: MIT
 *
 * raymap repair: a damaged map made whole again of what is left.
 */
#include "accel/accel.h"
#include "base/grouped.h"
#include "io/map/map_lock.h"
#include "io/recovery/repair.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/upkeep/repair_run.h"

static const struct rmap_option options[] = {
    {"dry-run", 'n', NULL, "say what is wrong; change nothing"},
    {"scene", 0, "FILE", "the scene that was traced, for a map whose index is gone"},
    {"break-lock", 0, NULL, "remove an ended writer's lock (file systems without locks)"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

static json_t *notes_json(const struct rmap_findings *notes)
{
    json_t *list = json_array();
    for (size_t i = 0; i < notes->n; i++)
        (void)json_array_append_new(list, json_pack("{s:s, s:s, s:s}", "file", notes->row[i].file,
                                                    "dataset", notes->row[i].dataset, "text",
                                                    notes->row[i].text));
    return list;
}

static json_t *to_json(const char *path, const struct rmap_repair_result *result)
{
    char digest[33];
    json_t *ranges = json_array();
    for (size_t i = 0; i < result->lost.n; i++)
        (void)json_array_append_new(ranges,
                                    json_pack("[I,I]", (json_int_t)result->lost.range[i].first,
                                              (json_int_t)(result->lost.range[i].end - 1)));
    rmap_digest_text(result->summary.digest, digest);
    return json_pack("{s:s, s:o, s:o, s:o, s:{s:I, s:o}, s:I, s:I, s:b, s:s, s:f}", "map", path,
                     "found", notes_json(&result->found), "done", notes_json(&result->done), "left",
                     notes_json(&result->left), "lost", "rays",
                     (json_int_t)rmap_ray_set_count(&result->lost), "ray_ranges", ranges, "rays",
                     (json_int_t)result->summary.n_row[RMAP_TABLE_RAY], "missing",
                     (json_int_t)result->n_missing, "complete", (int)result->summary.complete,
                     "digest", digest, "seconds", result->seconds);
}

static void print_notes(const char *what, const struct rmap_findings *notes, FILE *out)
{
    for (size_t i = 0; i < notes->n; i++) {
        const struct rmap_finding *note = &notes->row[i];
        fprintf(out, "%s %s%s%s%s%s\n", what, note->file, note->dataset[0] ? ": " : "",
                note->dataset, note->file[0] ? ": " : "", note->text);
    }
}

static void print_text(const char *path, const struct rmap_repair_result *result, FILE *out)
{
    const size_t shown = 20;
    char lost[RMAP_GROUPED_LEN], missing[RMAP_GROUPED_LEN];
    print_notes("found", &result->found, out);
    print_notes("done ", &result->done, out);
    print_notes("left ", &result->left, out);
    for (size_t i = 0; i < result->lost.n && i < shown; i++)
        fprintf(out, "lost  rays %llu to %llu\n", (unsigned long long)result->lost.range[i].first,
                (unsigned long long)(result->lost.range[i].end - 1));
    if (result->lost.n > shown)
        fprintf(out, "lost  and %s of rays\n",
                rmap_counted(result->lost.n - shown, "more range").text);
    fprintf(out, "%s: %s, %s lost, %s missing of those asked for: %s\n", path,
            rmap_counted(result->summary.n_row[RMAP_TABLE_RAY], "ray").text,
            rmap_grouped(rmap_ray_set_count(&result->lost), lost),
            rmap_grouped(result->n_missing, missing),
            result->summary.complete ? "complete"
            : result->is_picked
                ? "not complete; the query that picked them, asked again, picks all of them"
                : "not complete; raymap trace SCENE -o MAP --resume traces them again");
}

/* Of --dry-run. */
static void print_found(const char *path, const struct rmap_findings *found, bool quiet, FILE *out)
{
    print_notes("found", found, out);
    if (found->n == 0 && !quiet)
        fprintf(out, "%s: nothing is wrong; nothing was changed\n", path);
}

static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             const struct rmap_repair_result *result, enum rmap_repair_mode mode,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (context->json)
        st = rmap_json_print(to_json(path, result), stdout, err);
    else if (mode == RMAP_REPAIR_SAY)
        print_found(path, &result->found, context->quiet, stdout);
    else if (!context->quiet)
        print_text(path, result, stdout);
    if (st == RMAP_OK && mode == RMAP_REPAIR_SAY && result->found.n > 0)
        st = rmap_error_set(err, RMAP_FORMAT, "%s is damaged in %s; nothing was changed", path,
                            rmap_counted(result->found.n, "place").text);
    if (st == RMAP_OK && result->left.n > 0)
        st = rmap_error_set(err, RMAP_FORMAT, "%s: %s%s%s; this is left as it is", path,
                            result->left.row[0].file, result->left.row[0].file[0] ? ": " : "",
                            result->left.row[0].text);
    return st;
}

/* Collective. The scene that --scene names; nothing without it. */
static enum rmap_status load_scene(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_bundle **bundle,
                                   struct rmap_scene **scene, struct rmap_error *err)
{
    struct rmap_scene_options choices = {0};
    static const char *const of_scene[] = {"simulation", "only", "without", "set", "color"};
    const char *path = rmap_argument(given, "scene");
    for (size_t i = 0; !path && i < sizeof of_scene / sizeof *of_scene; i++)
        if (rmap_argument(given, of_scene[i]))
            return rmap_error_set(err, RMAP_USAGE, "--%s goes with --scene", of_scene[i]);
    if (!path)
        return RMAP_OK;
    enum rmap_status st = rmap_scene_options_read(given, &choices, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, path, &choices, bundle, scene, err));
out:
    return st;
}

static enum rmap_status run_repair(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    const char *path = given->operand[0];
    enum rmap_repair_mode mode = rmap_argument(given, "dry-run") ? RMAP_REPAIR_SAY : RMAP_REPAIR_DO;
    struct rmap_repair_result result = {0};
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene *scene = NULL;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(load_scene(context, given, &bundle, &scene, err));
    const struct rmap_run run = {
        .bundle = bundle, .scene = scene, .embree_version = rmap_accel_embree_version()};
    if (context->rank == 0 && rmap_argument(given, "break-lock"))
        st = rmap_map_lock_break(path, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_repair_run(context, path, scene ? &run : NULL, mode, &result, err));
    if (context->rank == 0)
        st = tell(context, path, &result, mode, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_repair_result_fini(&result);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(bundle);
    return st;
}

const struct rmap_command rmap_command_repair = {
    .name = "repair",
    .summary = "make a damaged map whole again of what is left of it",
    .operands = "MAP [--dry-run] [--scene FILE]",
    .help =
        "Verifies the map, then mends what is wrong: makes the index again from the pieces, takes\n"
        "in what a killed trace left, writes what is good of damaged pieces anew, removes what is\n"
        "damaged, and says which rays are lost. Rays are never invented: what is missing,\n"
        "`raymap trace SCENE -o MAP --resume` traces again. No trace may be running on the map.\n"
        "Killed in the middle, it can be started again.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_repair,
};
