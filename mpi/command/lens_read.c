/* SPDX-License-Identifier: MIT
 *
 * A lens file with its glass catalogues, and the scene that is made of it.
 */
#include "mpi/command/lens_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/input_file.h"
#include "io/lensfile/lens_plain.h"
#include "io/lensfile/lens_scene.h"
#include "io/lensfile/lens_zar.h"
#include "mpi/command/output.h"
#include "mpi/command/scene_check.h"

enum { FILE_NBYTES_MAX = 64 << 20, PATH = 4096 };

void rmap_lens_import_init(struct rmap_lens_import *import, const char *path, const char *scene,
                           const struct rmap_arguments *given)
{
    *import = (struct rmap_lens_import){.path = path, .scene = scene, .given = given};
    rmap_diagnostics_init(&import->findings, path);
}

void rmap_lens_import_fini(struct rmap_lens_import *import)
{
    rmap_lens_plan_fini(&import->plan);
    rmap_prescription_fini(&import->lens);
    rmap_diagnostics_fini(&import->findings);
    free(import->text);
}

/* How much of a path is its folder, with the slash; 0: no folder is named. */
static int folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path) + 1 : 0;
}

static enum rmap_status read_glass(struct rmap_lens_import *import, const char *path,
                                   struct rmap_error *err)
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
    struct rmap_lens_import *import = context;
    (void)directory;
    (void)err;
    if (rmap_output_is(name, ".agf") && import->n_beside < RMAP_LENS_CATALOGUES_MAX &&
        strlen(name) < sizeof import->beside[0])
        (void)snprintf(import->beside[import->n_beside++], sizeof import->beside[0], "%s", name);
    return RMAP_OK;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

/* A bad one beside the lens file is told and left out: nobody asked for it. */
static enum rmap_status read_beside(struct rmap_lens_import *import, struct rmap_error *err)
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

static enum rmap_status read_glasses(struct rmap_lens_import *import, struct rmap_error *err)
{
    const struct rmap_arguments *given = import->given;
    enum rmap_status st = read_beside(import, err);
    for (size_t i = 0; i < given->n_value && st == RMAP_OK; i++)
        if (strcmp(given->value[i].option->name, "glass") == 0)
            st = read_glass(import, given->value[i].text, err);
    return st;
}

/* The first lens in an archive, and all catalogues. */
static enum rmap_status read_archive(struct rmap_lens_import *import, const uint8_t *bytes,
                                     size_t nbytes, int configuration, struct rmap_error *err)
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
    for (int n = 0; st == RMAP_OK && found && n < RMAP_LENS_CATALOGUES_MAX; n++) {
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
static enum rmap_status read_lens(struct rmap_lens_import *import, int configuration,
                                  struct rmap_error *err)
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
    return st == RMAP_OK ? read_glasses(import, err) : st;
}

const char *rmap_lens_import_name(const struct rmap_lens_import *import)
{
    return import->path + folder_length(import->path);
}

/* ---- a scene that its reader takes ---- */

static enum rmap_status write_text(struct rmap_lens_import *import, struct rmap_error *err)
{
    free(import->text);
    import->text = NULL;
    FILE *memory = open_memstream(&import->text, &import->text_nbytes);
    if (memory)
        rmap_lens_scene_write(&import->plan, rmap_lens_import_name(import), memory);
    if (!memory || fclose(memory) != 0)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    return RMAP_OK;
}

/* What `raymap check` says of the text; RMAP_INPUT is for the list. */
static enum rmap_status check_text(const struct rmap_lens_import *import, bool *readable,
                                   struct rmap_diagnostics *told, struct rmap_error *err)
{
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene_checked checked = {0};
    enum rmap_status st = rmap_bundle_of_text(import->scene, import->text, NULL, &bundle, err);
    if (st == RMAP_OK)
        st = rmap_scene_check(bundle, 1, 1, told, &checked, err);
    *readable = checked.scene != NULL;
    rmap_scene_checked_fini(&checked);
    rmap_bundle_destroy(bundle);
    return st == RMAP_INPUT ? RMAP_OK : st;
}

/* Of the first error that a source is to be blamed for, or a surface that cannot be read. False: of
 * none. */
static bool make_plainer(struct rmap_lens_import *import, bool readable,
                         const struct rmap_diagnostics *told)
{
    static const char source[] = "ource 'field_";
    for (size_t i = 0; i < told->n; i++) {
        const char *text = told->item[i].text, *of = strstr(text, source);
        size_t at = 0;
        if (told->item[i].severity != RMAP_SEVERITY_ERROR ||
            (!of && (readable ||
                     !rmap_lens_scene_line(&import->plan, import->text, told->item[i].line, &at))))
            continue;
        if (of ? rmap_lens_move_source(&import->lens, strtoul(of + sizeof source - 1, NULL, 10) - 1,
                                       text)
               : rmap_lens_make_plainer(&import->lens, at, text))
            return true;
    }
    return false;
}

static enum rmap_status plan_and_write(struct rmap_lens_import *import, struct rmap_error *err)
{
    enum rmap_status st = rmap_lens_plan_make(&import->lens, &import->plan, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", import->path);
    return st == RMAP_OK ? write_text(import, err) : st;
}

enum rmap_status rmap_lens_import_read(struct rmap_lens_import *import, int k,
                                       struct rmap_error *err)
{
    enum { AGAIN_MAX = 200 };
    struct rmap_lens_kept kept = {.surface = NULL};
    enum rmap_status st = read_lens(import, k, err);
    if (st == RMAP_OK)
        st = rmap_lens_keep(&import->lens, &kept, err);
    if (st == RMAP_OK)
        st = plan_and_write(import, err);
    bool again = true, readable = false;
    for (int i = 0; i < AGAIN_MAX && st == RMAP_OK && again; i++) {
        struct rmap_diagnostics told;
        rmap_diagnostics_init(&told, import->scene);
        st = check_text(import, &readable, &told, err);
        const bool refused = st == RMAP_OK && told.n_error > 0;
        if (refused)
            rmap_lens_put_back(&import->lens, &kept);
        again = refused && make_plainer(import, readable, &told);
        rmap_diagnostics_fini(&told);
        if (refused)
            st = rmap_lens_keep(&import->lens, &kept, err);
        if (refused && st == RMAP_OK) {
            rmap_lens_plan_fini(&import->plan);
            st = plan_and_write(import, err);
        }
    }
    rmap_lens_kept_fini(&kept);
    return st;
}
