/* SPDX-License-Identifier: MIT
 *
 * The folder of an import.
 */
#include "mpi/command/import_folder.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/assembly/assembly_scene.h"
#include "io/file/directory.h"
#include "io/file/kept_edits.h"
#include "io/file/publish.h"
#include "mpi/command/model_store.h"

char *rmap_import_path(const char *folder, const char *name)
{
    const size_t n = strlen(folder);
    return rmap_path_format("%s%s%s", folder, n > 0 && folder[n - 1] == '/' ? "" : "/", name);
}

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name");
}

/* Neither the folder nor one above it is a file. */
static enum rmap_status check_path(const char *folder, struct rmap_error *err)
{
    char *name = rmap_strdup(folder);
    struct stat info;
    enum rmap_status st = name ? RMAP_OK : no_memory(err);
    if (st == RMAP_OK && !folder[0])
        st = rmap_error_set(err, RMAP_USAGE, "-o '' names no folder");
    for (size_t n = st == RMAP_OK ? strlen(name) : 0; n > 0; n--) {
        if (name[n] && name[n] != '/')
            continue;
        name[n] = 0;
        if (stat(name, &info) != 0)
            continue;
        if (!S_ISDIR(info.st_mode))
            st = rmap_error_set(err, RMAP_USAGE,
                                "-o %s: %s is a file: name a folder, which is made where it is not "
                                "there",
                                folder, name);
        break;
    }
    rmap_free(name);
    return st;
}

static enum rmap_status look(struct rmap_import_folder *place, enum rmap_edits *scene,
                             bool *has_parts, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_error unheard = {0};
    char *stored = rmap_import_path(place->path, RMAP_ASSEMBLY_MESHES "/assembly.json"),
         *parts = rmap_import_path(place->path, RMAP_ASSEMBLY_PARTS),
         *path = rmap_import_path(place->path, "scene.yaml");
    if (!stored || !parts || !path)
        RMAP_TRY(no_memory(err));
    *has_parts = access(parts, F_OK) == 0;
    RMAP_TRY(rmap_edits_find(path, scene, err));
    place->has_model = access(stored, F_OK) == 0;
    if (place->has_model)
        st = rmap_model_read_stored(place->path, &place->before, &unheard);
    if (st != RMAP_OK) {
        rmap_assembly_fini(&place->before); /* a damaged one names no files that could go */
        place->before = (struct rmap_assembly){0};
    }
    if (st == RMAP_SYSTEM)
        *err = unheard;
    else
        st = RMAP_OK;
out:
    rmap_free(stored);
    rmap_free(parts);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_import_folder_check(struct rmap_import_folder *place,
                                          enum rmap_import_kind kind, bool force,
                                          struct rmap_error *err)
{
    enum rmap_edits scene = RMAP_EDITS_NO_FILE;
    bool has_parts = false;
    enum rmap_status st = check_path(place->path, err);
    if (st == RMAP_OK)
        st = look(place, &scene, &has_parts, err);
    if (st != RMAP_OK || force)
        return st;
    if (kind == RMAP_IMPORT_LENS && place->has_model)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s holds a model (%s) and its meshes, not a lens: -o names another "
                              "folder; --force replaces it, keeps edited texts and removes its "
                              "meshes",
                              place->path,
                              place->before.source ? place->before.source : "imported before");
    if (kind == RMAP_IMPORT_MODEL && !place->has_model && !has_parts && scene == RMAP_EDITS_NONE)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s holds the scene of a lens, not of a model: -o names another "
                              "folder; --force replaces it",
                              place->path);
    return RMAP_OK;
}

enum rmap_status rmap_import_folder_make(struct rmap_import_folder *place, struct rmap_error *err)
{
    const enum rmap_status st = rmap_folder_make_all(place->path, &place->had, err);
    place->made = st == RMAP_OK;
    return st;
}

static size_t remove_file(const char *folder, const char *name, bool edits_matter)
{
    struct rmap_error unheard = {0};
    enum rmap_edits edits = RMAP_EDITS_NONE;
    char *path = rmap_import_path(folder, name);
    const bool free_to_go =
        path && (!edits_matter ||
                 (rmap_edits_find(path, &edits, &unheard) == RMAP_OK && edits == RMAP_EDITS_NONE));
    const size_t n = free_to_go && unlink(path) == 0;
    rmap_free(path);
    return n;
}

void rmap_import_folder_replaced(const struct rmap_import_folder *place, bool quiet)
{
    char *meshes = place->has_model ? rmap_import_path(place->path, RMAP_ASSEMBLY_MESHES) : NULL;
    size_t n = 0;
    if (!meshes)
        return;
    for (size_t i = 0; i < place->before.n_shape; i++)
        n += remove_file(meshes, place->before.shape[i].file, false);
    (void)remove_file(meshes, "assembly.json", false);
    (void)remove_file(place->path, RMAP_ASSEMBLY_PARTS, true);
    (void)remove_file(place->path, RMAP_ASSEMBLY_ATTRIBUTES, true);
    (void)rmdir(meshes); /* where nothing else is in it */
    if (!quiet)
        (void)fprintf(stderr, "%s: the model that was imported there is gone, with %zu meshes\n",
                      place->path, n);
    rmap_free(meshes);
}

void rmap_import_folder_fini(struct rmap_import_folder *place, enum rmap_status st)
{
    if (st != RMAP_OK && place->made)
        rmap_folder_unmake(place->path, place->had);
    rmap_assembly_fini(&place->before);
}
