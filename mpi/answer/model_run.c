/* SPDX-License-Identifier: MIT
 *
 * Importing a model, and updating what was imported.
 */
#include "mpi/answer/model_run.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/unit.h"
#include "io/file/directory.h"
#include "mpi/answer/model_out.h"
#include "mpi/answer/model_rules.h"
#include "mpi/command/command.h"
#include "mpi/command/import_check.h"
#include "mpi/command/import_folder.h"
#include "mpi/command/json_out.h"
#include "mpi/command/model_read.h"
#include "mpi/command/output.h"
#include "mpi/parallel/interrupt.h"

enum rmap_status rmap_model_check_options(const struct rmap_arguments *given, const char *path,
                                          struct rmap_error *err)
{
    static const char *const step[] = {".step", ".stp", ".iges", ".igs", NULL},
                             *const without_unit[] = {".obj", ".stl", ".ply", NULL},
                             *const lens[] = {".zmx", ".zar", ".seq", ".len", NULL};
    static const struct {
        const char *option, *of;
        const char *const *suffix;
    } rules[] = {{"chord", "STEP and IGES, whose faces it cuts into triangles", step},
                 {"angle", "STEP and IGES, whose faces it cuts into triangles", step},
                 {"unit", "OBJ, STL and PLY, which name none", without_unit},
                 {"glass", "lens files", lens}};
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++) {
        bool fits = !rmap_argument(given, rules[i].option);
        for (const char *const *suffix = rules[i].suffix; *suffix && !fits; suffix++)
            fits = rmap_output_is(path, *suffix);
        if (!fits)
            return rmap_error_set(err, RMAP_USAGE,
                                  "--%s says nothing of %s: it is for %s; leave it out",
                                  rules[i].option, path, rules[i].of);
    }
    return RMAP_OK;
}

static enum rmap_status request_of(const struct rmap_arguments *given, const char *path,
                                   const char *folder, struct rmap_model_request *request,
                                   struct rmap_error *err)
{
    const double mm = 1e-3;
    const char *word = rmap_argument(given, "unit");
    const struct rmap_written_unit *unit =
        word ? rmap_unit_of_scene(word, RMAP_DIMENSION_LENGTH) : NULL;
    *request = (struct rmap_model_request){.path = path,
                                           .folder = folder,
                                           .chord = rmap_argument(given, "chord"),
                                           .angle = rmap_argument(given, "angle"),
                                           .unit = word ? word : "",
                                           .is_update = given->n_operand > 1,
                                           .scale = unit ? unit->size / mm : 1};
    return word && !unit ? rmap_error_set(err, RMAP_USAGE,
                                          "--unit %.40s: a length is in nm um mm cm m in", word)
                         : RMAP_OK;
}

/* What was asked for at the import, where nothing else is asked for now. */
static void remember(const struct rmap_assembly *before, struct rmap_model_request *request,
                     char number[2][32])
{
    const double mm = 1e-3;
    const struct rmap_written_unit *unit =
        before->file_unit[0] ? rmap_unit_of_scene(before->file_unit, RMAP_DIMENSION_LENGTH) : NULL;
    (void)snprintf(number[0], 32, "%.17g", before->chord);
    (void)snprintf(number[1], 32, "%.17g", before->angle);
    if (!request->chord && before->chord > 0)
        request->chord = number[0];
    if (!request->angle && before->angle > 0)
        request->angle = number[1];
    if (request->unit[0] || !unit || strcmp(before->schema, "glTF 2.0") == 0)
        return;
    request->unit = before->file_unit;
    request->scale = unit->size / mm;
}

static void tell_kept(const struct rmap_context *context, const struct rmap_model_stored *stored)
{
    for (size_t i = 0; i < sizeof stored->kept / sizeof *stored->kept; i++)
        if (stored->kept[i] && !context->quiet)
            (void)fprintf(stderr, "%s: what stood there, with its edits\n", stored->kept[i]);
}

static enum rmap_status refuse_strictly(const struct rmap_arguments *given,
                                        const struct rmap_assembly *assembly, const char *path,
                                        struct rmap_error *err)
{
    if (assembly->findings.n == 0 || !rmap_argument(given, "strict"))
        return RMAP_OK;
    const size_t n = assembly->findings.n + assembly->findings.n_dropped;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s: %zu thing%s not as the file has %s; nothing is written, as "
                          "--strict asks",
                          path, n, n == 1 ? " is" : "s are", n == 1 ? "it" : "them");
}

enum rmap_status rmap_model_import(const struct rmap_context *context,
                                   const struct rmap_arguments *given, const char *folder,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly assembly = {0};
    struct rmap_model_stored stored = {0};
    struct rmap_model_request request;
    struct rmap_import_folder place = {.path = folder};
    struct rmap_diagnostics told;
    const bool force = rmap_argument(given, "force") != NULL;
    struct rmap_model_made made = {0};
    char *scene = rmap_model_path(folder, "scene.yaml");
    if (!scene)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name");
    rmap_diagnostics_init(&told, scene);
    RMAP_TRY(request_of(given, given->operand[0], folder, &request, err));
    RMAP_TRY(rmap_import_folder_check(&place, RMAP_IMPORT_MODEL, force, err)); /* before the work */
    RMAP_TRY(rmap_model_check_edits(folder, true, force, err));
    RMAP_TRY(rmap_import_folder_make(&place, err));
    RMAP_TRY(rmap_model_read(&request, &assembly, &made, err));
    rmap_diagnostics_print(&assembly.findings, stderr);
    RMAP_TRY(refuse_strictly(given, &assembly, request.path, err));
    RMAP_TRY(rmap_assembly_settle_labels(&assembly, err));
    RMAP_TRY(rmap_assembly_settle_files(&assembly, err));
    RMAP_TRY(rmap_interrupt_stopped(err));
    RMAP_TRY(rmap_model_store(folder, made.folder, &assembly,
                              place.has_model ? &place.before : NULL, NULL, force, &stored, err));
    tell_kept(context, &stored);
    RMAP_TRY(rmap_import_check(context, &(struct rmap_import_text){.path = scene}, &told, err));
    rmap_diagnostics_print(&told, stderr);
    if (context->json) {
        json_t *document = rmap_model_json(&assembly, request.path, scene);
        (void)json_object_set_new(document, "check", rmap_json_check(&told));
        RMAP_TRY(rmap_json_print(document, stdout, err));
    } else if (!context->quiet && told.n_error == 0) {
        rmap_model_print(&assembly, scene, stdout);
    }
    st = rmap_import_refused(scene, &told, err);
out:
    rmap_model_clean(&made);
    rmap_import_folder_fini(&place, st);
    rmap_diagnostics_fini(&told);
    rmap_model_stored_fini(&stored);
    rmap_assembly_fini(&assembly);
    rmap_free(scene);
    return st;
}

/* A model of something else would take the place of all parts. */
static enum rmap_status refuse_another(const struct rmap_assembly *before,
                                       const struct rmap_assembly_match *match, const char *path,
                                       const char *folder, struct rmap_error *err)
{
    size_t n = 0;
    for (size_t i = 0; i < before->n_part; i++) {
        if (before->part[i].shape >= 0 && match->to[i] >= 0)
            return RMAP_OK;
        n += before->part[i].shape >= 0;
    }
    if (n == 0)
        return RMAP_OK;
    return rmap_error_set(
        err, RMAP_USAGE,
        "%s: nothing of it is found again in %s: is it a revision of that model? "
        "`raymap import` with another -o brings a new model; --force replaces all "
        "of this one",
        folder, path);
}

enum rmap_status rmap_model_update(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *folder = given->operand[0];
    struct rmap_assembly before = {0}, after = {0};
    struct rmap_assembly_match match = {0};
    struct rmap_diagnostics rules[RMAP_MODEL_RULE_FILES] = {{0}};
    struct rmap_model_stored stored = {0};
    struct rmap_model_request request;
    const bool force = rmap_argument(given, "force") != NULL,
               dry_run = rmap_argument(given, "dry-run") != NULL;
    struct rmap_model_made made = {0};
    char number[2][32], *scene = rmap_model_path(folder, "scene.yaml");
    if (!scene)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name");
    if (!rmap_model_is_one(given->operand[1]))
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s: a model ends in .step .stp .iges .igs .gltf .glb .obj .stl "
                                ".ply",
                                given->operand[1]));
    RMAP_TRY(request_of(given, given->operand[1], folder, &request, err));
    RMAP_TRY(rmap_model_read_stored(folder, &before, err));
    RMAP_TRY(rmap_model_tell_missing(folder, &before.findings, err));
    remember(&before, &request, number);
    RMAP_TRY(rmap_model_check_edits(folder, false, force || dry_run, err));
    RMAP_TRY(rmap_model_read(&request, &after, &made, err));
    RMAP_TRY(rmap_interrupt_stopped(err));
    rmap_diagnostics_print(&before.findings, stderr);
    rmap_diagnostics_print(&after.findings, stderr);
    rmap_assembly_keep_frames(&before, &after);
    RMAP_TRY(rmap_assembly_match(&before, &after, &match, err));
    if (!force && !dry_run)
        RMAP_TRY(refuse_another(&before, &match, request.path, folder, err));
    RMAP_TRY(rmap_assembly_adopt(&before, &after, &match, err));
    RMAP_TRY(rmap_assembly_settle_labels(&after, err));
    RMAP_TRY(rmap_assembly_settle_files(&after, err));
    RMAP_TRY(rmap_model_check_rules(folder, &before, &after, &match, rules, err));
    for (int k = 0; k < RMAP_MODEL_RULE_FILES; k++)
        rmap_diagnostics_print(&rules[k], stderr);
    if (!dry_run)
        RMAP_TRY(
            rmap_model_store(folder, made.folder, &after, &before, &match, force, &stored, err));
    tell_kept(context, &stored);
    const struct rmap_model_revision revision = {&before, &after, &match, &stored, rules, dry_run};
    if (context->json)
        st = rmap_json_print(rmap_revision_json(&revision, request.path, scene), stdout, err);
    else if (!context->quiet)
        rmap_revision_print(&revision, scene, stdout);
out:
    rmap_model_clean(&made);
    rmap_model_stored_fini(&stored);
    rmap_assembly_match_fini(&match);
    for (int k = 0; k < RMAP_MODEL_RULE_FILES; k++)
        rmap_diagnostics_fini(&rules[k]);
    rmap_assembly_fini(&before);
    rmap_assembly_fini(&after);
    rmap_free(scene);
    return st;
}
