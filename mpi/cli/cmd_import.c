/* SPDX-License-Identifier: MIT
 *
 * raymap import: a scene of what lens designers and CAD programs have.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/input_file.h"
#include "io/file/kept_edits.h"
#include "io/lensfile/lens_scene.h"
#include "io/lensfile/lens_zar.h"
#include "io/scene/yaml_difference.h"
#include "mpi/answer/lens_out.h"
#include "mpi/answer/model_run.h"
#include "mpi/command/command.h"
#include "mpi/command/json_out.h"
#include "mpi/command/model_read.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"

enum {
    FILE_NBYTES_MAX = 64 << 20,
    PATH = 4096,
    BESIDE_MAX = 32,
    CONFIGURATIONS_MAX = 64,
    NAME_LETTERS = 80
};

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
    const struct rmap_arguments *given;
    struct rmap_prescription lens;
    struct rmap_lens_plan plan;
    struct rmap_diagnostics findings;
    char *text; /* of the scene; free() */
    size_t text_nbytes;
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

static enum rmap_status read_glasses(struct import *import, struct rmap_error *err)
{
    const struct rmap_arguments *given = import->given;
    enum rmap_status st = read_beside(import, err);
    for (size_t i = 0; i < given->n_value && st == RMAP_OK; i++)
        if (strcmp(given->value[i].option->name, "glass") == 0)
            st = read_glass(import, given->value[i].text, err);
    return st;
}

/* The first lens in an archive, and all catalogues. */
static enum rmap_status read_archive(struct import *import, const uint8_t *bytes, size_t nbytes,
                                     int configuration, struct rmap_error *err)
{
    struct rmap_zar_file file = {.nbytes = 0};
    size_t at = 0;
    bool found = false;
    enum rmap_status st = rmap_zar_next(bytes, nbytes, &at, ".zmx", &file, &found, err);
    if (st == RMAP_OK && !found)
        st = rmap_error_set(err, RMAP_INPUT, "no .zmx lies in it");
    if (st == RMAP_OK)
        st = rmap_prescription_read((const char *)file.bytes, file.nbytes, RMAP_LENS_ZMX,
                                    configuration, &import->findings, &import->lens, err);
    rmap_free(file.bytes);
    at = 0;
    for (int n = 0; st == RMAP_OK && found && n < BESIDE_MAX; n++) {
        st = rmap_zar_next(bytes, nbytes, &at, ".agf", &file, &found, err);
        if (st != RMAP_OK || !found)
            break;
        st = rmap_prescription_read_agf((const char *)file.bytes, file.nbytes, &import->lens, err);
        if (st == RMAP_INPUT) {
            rmap_diagnostics_add(&import->findings, RMAP_SEVERITY_WARNING, 0, 0,
                                 "glass catalogue %s in it: %s", file.name, err->text);
            st = RMAP_OK;
        }
        rmap_free(file.bytes);
    }
    return st;
}

/* configuration: from 1; 0: the one that is stored. */
static enum rmap_status read_lens(struct import *import, int configuration, struct rmap_error *err)
{
    enum rmap_lens_format format = RMAP_LENS_ZMX;
    const bool archive = rmap_output_is(import->path, ".zar");
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    if (rmap_output_is(import->path, ".agf"))
        return rmap_error_set(err, RMAP_USAGE, "%s is a glass catalogue: give it with --glass",
                              import->path);
    if (!archive && !rmap_lens_format_of(import->path, &format))
        return rmap_error_set(
            err, RMAP_USAGE,
            "%s: what is imported ends in .zmx or .zar (Zemax), .seq (CODE V), .len (OSLO), "
            "or .step .stp .iges .igs .gltf .glb .obj .stl .ply",
            import->path);
    enum rmap_status st = rmap_input_file_read(import->path, FILE_NBYTES_MAX, &bytes, &nbytes, err);
    if (st == RMAP_OK)
        st = archive ? read_archive(import, bytes, nbytes, configuration, err)
                     : rmap_prescription_read((const char *)bytes, nbytes, format, configuration,
                                              &import->findings, &import->lens, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", import->path);
    rmap_free(bytes);
    if (st == RMAP_OK)
        st = read_glasses(import, err);
    if (st == RMAP_OK) {
        st = rmap_lens_plan_make(&import->lens, &import->plan, err);
        if (st != RMAP_OK)
            rmap_error_context(err, "%s", import->path);
    }
    return st;
}

static enum rmap_status write_text(struct import *import, struct rmap_error *err)
{
    FILE *memory = open_memstream(&import->text, &import->text_nbytes);
    if (memory)
        rmap_lens_scene_write(&import->plan, import->path + folder_length(import->path), memory);
    if (!memory || fclose(memory) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    return RMAP_OK;
}

static void import_fini(struct import *import)
{
    rmap_lens_plan_fini(&import->plan);
    rmap_prescription_fini(&import->lens);
    rmap_diagnostics_fini(&import->findings);
    free(import->text);
}

/* ---- configurations ---- */

static enum rmap_status parse(const struct import *import, struct rmap_yaml_node **root,
                              struct rmap_error *err)
{
    struct rmap_diagnostics told;
    rmap_diagnostics_init(&told, import->scene);
    enum rmap_status st = rmap_yaml_parse(import->text, import->text_nbytes, root, &told, err);
    rmap_diagnostics_fini(&told);
    return st;
}

/* A simulation that sets what is other in configuration k. */
static enum rmap_status put_configuration(const struct import *import,
                                          const struct rmap_yaml_node *base, int k,
                                          char (*name)[NAME_LETTERS], FILE *file,
                                          struct rmap_error *err)
{
    struct import other = {.path = import->path, .given = import->given};
    struct rmap_yaml_node *root = NULL;
    char *set = NULL;
    size_t nbytes = 0;
    rmap_diagnostics_init(&other.findings, import->path);
    enum rmap_status st = read_lens(&other, k, err);
    if (st == RMAP_OK)
        st = write_text(&other, err);
    if (st == RMAP_OK)
        st = parse(&other, &root, err);
    FILE *memory = st == RMAP_OK ? open_memstream(&set, &nbytes) : NULL;
    if (st == RMAP_OK && !memory)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    if (memory) {
        const size_t n = rmap_yaml_difference(base, root, "      ", memory);
        const bool closed = fclose(memory) == 0;
        rmap_lens_configuration_name(&other.lens, k, name[k], NAME_LETTERS);
        for (int i = 1; i < k; i++)
            if (strcmp(name[i], name[k]) == 0)
                (void)snprintf(name[k], NAME_LETTERS, "configuration_%d", k);
        (void)fprintf(file, "  - name: %s\n    rays: 200000\n%s%s", name[k], n ? "    set:\n" : "",
                      closed && n ? set : "");
    }
    free(set);
    rmap_yaml_destroy(root);
    import_fini(&other);
    return st;
}

static enum rmap_status put_scene(const void *context, FILE *file, struct rmap_error *err)
{
    const struct import *import = context;
    struct rmap_yaml_node *base = NULL;
    char name[CONFIGURATIONS_MAX + 1][NAME_LETTERS];
    enum rmap_status st = RMAP_OK;
    (void)fwrite(import->text, 1, import->text_nbytes, file);
    if (import->lens.n_configuration > 1)
        st = parse(import, &base, err);
    for (int k = 1;
         base && k <= import->lens.n_configuration && k <= CONFIGURATIONS_MAX && st == RMAP_OK; k++)
        st = put_configuration(import, base, k, name, file, err);
    rmap_yaml_destroy(base);
    return st;
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
    st = read_lens(import, 0, err);
    rmap_diagnostics_print(&import->findings, stderr);
    if (st == RMAP_OK && import->findings.n > 0 && rmap_argument(given, "strict"))
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s: %zu things are not understood; nothing is written, as --strict "
                            "asks",
                            import->path, import->findings.n + import->findings.n_dropped);
    RMAP_TRY(st);
    RMAP_TRY(write_text(import, err));
    RMAP_TRY(rmap_folder_make(import->folder, err));
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
    struct import import = {
        .path = given->operand[0], .folder = rmap_argument(given, "output"), .given = given};
    enum rmap_status st = RMAP_OK;
    rmap_diagnostics_init(&import.findings, import.path);
    if (!import.folder)
        st = rmap_error_set(err, RMAP_USAGE, "-o FOLDER is missing: where the scene goes");
    else if (context->rank == 0 && rmap_model_is_one(import.path))
        st = rmap_model_import(context, given, import.folder, err);
    else if (context->rank == 0)
        st = import_lens(context, given, &import, err);
    st = rmap_agree(context, st, err);
    import_fini(&import);
    return st;
}

const struct rmap_command rmap_command_import = {
    .name = "import",
    .summary = "write a scene of a lens or CAD file",
    .operands = "FILE -o FOLDER",
    .help =
        "Reads a lens of Zemax (.zmx, .zar), CODE V (.seq) or OSLO (.len) and writes "
        "FOLDER/scene.yaml,\n"
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
