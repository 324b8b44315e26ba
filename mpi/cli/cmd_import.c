/* SPDX-License-Identifier: MIT
 *
 * raymap import: a scene of what lens designers and CAD programs have.
 */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/input_file.h"
#include "io/file/kept_edits.h"
#include "io/lensfile/lens_scene.h"
#include "mpi/answer/lens_out.h"
#include "mpi/answer/model_run.h"
#include "mpi/command/command.h"
#include "mpi/command/json_out.h"
#include "mpi/command/model_read.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"

enum { FILE_NBYTES_MAX = 64 << 20, PATH = 4096, BESIDE_MAX = 32 };

static const struct rmap_option options[] = {
    {"output", 'o', "FOLDER", "where the scene goes, as FOLDER/scene.yaml"},
    {"glass", 0, "FILE.agf" RMAP_ARGUMENT_AGAIN,
     "a glass catalogue; those beside the lens file are read without being named"},
    RMAP_MODEL_OPTIONS,
    {"strict", 0, NULL, "write nothing if anything is not understood: status 3"},
    {"force", 'f', NULL, "keep an edited scene.yaml as scene.yaml.bak, and write a new one"},
    {NULL}};

struct import {
    const char *path, *folder;
    char scene[PATH];
    struct rmap_prescription lens;
    struct rmap_lens_plan plan;
    struct rmap_diagnostics findings;
    size_t n_beside;
    char beside[BESIDE_MAX][NAME_MAX + 1]; /* glass catalogues in the lens file's folder */
};

/* How much of a path is its folder, with the slash; 0: no folder is named. */
static int folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path) + 1 : 0;
}

static enum rmap_status read_glass(struct import *import, const char *path, struct rmap_error *err)
{
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_input_file_read(path, FILE_NBYTES_MAX, &bytes, &nbytes, err);
    if (st == RMAP_OK)
        st = rmap_prescription_read_agf((const char *)bytes, nbytes, &import->lens, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "glass catalogue %s", path);
    rmap_free(bytes);
    return st;
}

static enum rmap_status visit_beside(void *context, int directory, const char *name,
                                     struct rmap_error *err)
{
    struct import *import = context;
    (void)directory;
    (void)err;
    if (rmap_output_is(name, ".agf") && import->n_beside < BESIDE_MAX &&
        strlen(name) < sizeof import->beside[0])
        (void)snprintf(import->beside[import->n_beside++], sizeof import->beside[0], "%s", name);
    return RMAP_OK;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

/* A bad one beside the lens file is told and left out: nobody asked for it. */
static enum rmap_status read_beside(struct import *import, struct rmap_error *err)
{
    char path[PATH];
    const int n_folder = folder_length(import->path);
    (void)snprintf(path, sizeof path, "%.*s", n_folder ? n_folder : 2,
                   n_folder ? import->path : "./");
    enum rmap_status st = rmap_directory_visit(path, visit_beside, import, err);
    /* Of two glasses of a name the first counts: not the one that the file system lists first. */
    qsort(import->beside, import->n_beside, sizeof import->beside[0], by_name);
    for (size_t i = 0; i < import->n_beside && st == RMAP_OK; i++) {
        if (snprintf(path, sizeof path, "%.*s%s", n_folder, import->path, import->beside[i]) >=
            PATH)
            continue;
        st = read_glass(import, path, err);
        if (st != RMAP_INPUT)
            continue;
        rmap_diagnostics_add(&import->findings, RMAP_SEVERITY_WARNING, 0, 0, "%s", err->text);
        st = RMAP_OK;
    }
    return st;
}

static enum rmap_status read_glasses(struct import *import, const struct rmap_arguments *given,
                                     struct rmap_error *err)
{
    enum rmap_status st = read_beside(import, err);
    for (size_t i = 0; i < given->n_value && st == RMAP_OK; i++)
        if (strcmp(given->value[i].option->name, "glass") == 0)
            st = read_glass(import, given->value[i].text, err);
    return st;
}

static enum rmap_status read_lens(struct import *import, const struct rmap_arguments *given,
                                  struct rmap_error *err)
{
    enum rmap_lens_format format = RMAP_LENS_ZMX;
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    enum rmap_status st = RMAP_OK;
    if (rmap_output_is(import->path, ".zar"))
        return rmap_error_set(err, RMAP_INPUT,
                              "%s: how a .zar is packed is not public: save it as .zmx, which is "
                              "read with its .agf beside it",
                              import->path);
    if (rmap_output_is(import->path, ".agf"))
        return rmap_error_set(err, RMAP_USAGE, "%s is a glass catalogue: give it with --glass",
                              import->path);
    if (!rmap_lens_format_of(import->path, &format))
        return rmap_error_set(
            err, RMAP_USAGE,
            "%s: what is imported ends in .zmx (Zemax), .seq (CODE V), .len (OSLO), "
            "or .step .stp .iges .igs .gltf .glb .obj .stl .ply",
            import->path);
    st = rmap_input_file_read(import->path, FILE_NBYTES_MAX, &bytes, &nbytes, err);
    if (st == RMAP_OK)
        st = rmap_prescription_read((const char *)bytes, nbytes, format, &import->findings,
                                    &import->lens, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", import->path);
    rmap_free(bytes);
    if (st == RMAP_OK)
        st = read_glasses(import, given, err);
    return st;
}

static enum rmap_status make_folder(const char *folder, struct rmap_error *err)
{
    const mode_t all = 0777;
    struct stat info;
    if (mkdir(folder, all) == 0)
        return RMAP_OK;
    const int why = errno;
    if (why == EEXIST && stat(folder, &info) == 0 && S_ISDIR(info.st_mode))
        return RMAP_OK;
    return rmap_error_set(err, why == EEXIST ? RMAP_USAGE : RMAP_SYSTEM,
                          "folder %s cannot be made: %s", folder, strerror(why));
}

static enum rmap_status put_scene(const void *context, FILE *file, struct rmap_error *err)
{
    const struct import *import = context;
    (void)err;
    rmap_lens_scene_write(&import->plan, import->path + folder_length(import->path), file);
    return RMAP_OK;
}

static enum rmap_status import_lens(const struct rmap_context *context,
                                    const struct rmap_arguments *given, struct import *import,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    enum rmap_edits edits = RMAP_EDITS_NO_FILE;
    const bool force = rmap_argument(given, "force") != NULL;
    char *kept = NULL;
    const size_t n = strlen(import->folder);
    const bool slash = n > 0 && import->folder[n - 1] == '/';
    if (snprintf(import->scene, sizeof import->scene, "%s%sscene.yaml", import->folder,
                 slash ? "" : "/") >= PATH)
        return rmap_error_set(err, RMAP_USAGE, "the name of the folder is too long");
    RMAP_TRY(rmap_edits_find(import->scene, &edits, err)); /* before the work */
    if (edits == RMAP_EDITS_MADE && !force)
        RMAP_TRY(rmap_edits_refuse(import->scene, err));
    RMAP_TRY(read_lens(import, given, err));
    st = rmap_lens_plan_make(&import->lens, &import->plan, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", import->path);
    rmap_diagnostics_print(&import->findings, stderr);
    if (st == RMAP_OK && import->findings.n > 0 && rmap_argument(given, "strict"))
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s: %zu things are not understood; nothing is written, as --strict "
                            "asks",
                            import->path, import->findings.n + import->findings.n_dropped);
    RMAP_TRY(st);
    RMAP_TRY(make_folder(import->folder, err));
    RMAP_TRY(rmap_edits_put(import->scene, force, put_scene, import, &kept, err));
    if (kept && !context->quiet)
        (void)fprintf(stderr, "%s: the scene that stood there, with its edits\n", kept);
    if (context->json)
        st = rmap_json_print(rmap_lens_json(&import->plan, import->path, import->scene), stdout,
                             err);
    else if (!context->quiet)
        rmap_lens_print(&import->plan, import->scene, stdout);
out:
    rmap_free(kept);
    return st;
}

/* Rank 0 does it all. */
static enum rmap_status run_import(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct import import = {.path = given->operand[0], .folder = rmap_argument(given, "output")};
    enum rmap_status st = RMAP_OK;
    rmap_diagnostics_init(&import.findings, import.path);
    if (!import.folder)
        st = rmap_error_set(err, RMAP_USAGE, "-o FOLDER is missing: where the scene goes");
    else if (context->rank == 0 && rmap_model_is_one(import.path))
        st = rmap_model_import(context, given, import.folder, err);
    else if (context->rank == 0)
        st = import_lens(context, given, &import, err);
    st = rmap_agree(context, st, err);
    rmap_lens_plan_fini(&import.plan);
    rmap_prescription_fini(&import.lens);
    rmap_diagnostics_fini(&import.findings);
    return st;
}

const struct rmap_command rmap_command_import = {
    .name = "import",
    .summary = "write a scene of a lens or CAD file",
    .operands = "FILE -o FOLDER",
    .help =
        "Reads a lens of Zemax (.zmx), CODE V (.seq) or OSLO (.len) and writes FOLDER/scene.yaml,\n"
        "to be read and edited like any other: glasses by their names, apertures, stops, mirrors,\n"
        "tilts, fields as sources, the image as a detector. What is not understood is told with\n"
        "its line and surface, and stands as a remark in the scene; --strict makes it a mistake.\n"
        "A scene of an import is replaced; one that was edited since is not, unless --force is "
        "given,\n"
        "which keeps it as scene.yaml.bak.\n\n"
        "Of a model (STEP and IGES where raymap-step is installed, glTF, OBJ, STL, PLY) the tree "
        "of\n"
        "parts goes to FOLDER/parts.yaml and their meshes to FOLDER/meshes; scene.yaml and\n"
        "attributes.yaml, rules that say what parts are made of, are for you to edit: `raymap\n"
        "update` brings the model's next revision and keeps them.\n\n"
        "  raymap import double-gauss.zmx -o lens\n"
        "  raymap trace lens/scene.yaml -n 1M -o lens.raymap\n"
        "  raymap ghosts lens.raymap sensor\n"
        "  raymap import lamp.step -o lamp",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_import,
};
