/* SPDX-License-Identifier: MIT
 *
 * The folder of an imported model.
 */
#include "mpi/command/model_store.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/assembly/assembly_scene.h"
#include "io/assembly/ply_write.h"
#include "io/export/json_memory.h"
#include "io/file/directory.h"
#include "io/file/input_file.h"
#include "io/file/kept_edits.h"
#include "io/file/publish.h"
#include "io/file/whole_file.h"
#include "mpi/command/model_read.h"

#define STORED RMAP_ASSEMBLY_MESHES "/assembly.json"

static const struct {
    const char *name;
    enum rmap_status (*put)(const void *context, FILE *out, struct rmap_error *err);
    bool of_user;
} text[] = {{RMAP_ASSEMBLY_PARTS, rmap_assembly_put_parts, false},
            {RMAP_ASSEMBLY_ATTRIBUTES, rmap_assembly_put_attributes, true},
            {"scene.yaml", rmap_assembly_put_scene, true}};
enum { N_TEXT = sizeof text / sizeof *text };

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a file's name");
}

char *rmap_model_path(const char *folder, const char *name)
{
    const size_t n = strlen(folder);
    return rmap_path_format("%s%s%s", folder, n > 0 && folder[n - 1] == '/' ? "" : "/", name);
}

static enum rmap_status check_one(const char *path, bool of_user, bool force,
                                  struct rmap_error *err)
{
    enum rmap_edits edits = RMAP_EDITS_NO_FILE;
    const enum rmap_status st = rmap_edits_find(path, &edits, err);
    if (st != RMAP_OK || edits != RMAP_EDITS_MADE || force)
        return st;
    if (of_user)
        return rmap_error_set(
            err, RMAP_USAGE,
            "%s has edits: `raymap update` brings a new revision of the model and "
            "keeps them; --force keeps it as %s.bak and begins anew",
            path, path);
    return rmap_error_set(
        err, RMAP_USAGE,
        "%s has edits, and is written anew for each revision: put them into rules "
        "in " RMAP_ASSEMBLY_ATTRIBUTES
        " or into scene.yaml; --force keeps it as %s.bak and writes it anew",
        path, path);
}

enum rmap_status rmap_model_check_edits(const char *folder, bool with_user, bool force,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < N_TEXT && st == RMAP_OK; i++) {
        if (text[i].of_user && !with_user)
            continue;
        char *path = rmap_model_path(folder, text[i].name);
        st = path ? check_one(path, text[i].of_user, force, err) : no_memory(err);
        rmap_free(path);
    }
    return st;
}

static char *mesh_path(const char *folder, const char *file)
{
    return rmap_path_format("%s/" RMAP_ASSEMBLY_MESHES "/%s", folder, file);
}

/* Of a mesh file's bytes; false: it cannot be read. */
static bool digest_of(const char *path, uint64_t *digest)
{
    uint8_t block[1 << 14];
    FILE *file = fopen(path, "rb");
    XXH3_state_t *state = file ? XXH3_createState() : NULL;
    bool good = state && XXH3_64bits_reset(state) == XXH_OK;
    for (size_t n; good && (n = fread(block, 1, sizeof block, file)) > 0;)
        good = XXH3_64bits_update(state, block, n) == XXH_OK;
    good = good && !ferror(file);
    *digest = good ? XXH3_64bits_digest(state) : 0;
    (void)XXH3_freeState(state);
    if (file)
        (void)fclose(file);
    return good;
}

/* A mesh that somebody took away or changed is of no shape, so that an update brings it again. */
static enum rmap_status forget_damaged(const char *folder, struct rmap_assembly *assembly,
                                       struct rmap_error *err)
{
    for (size_t i = 0; i < assembly->n_shape; i++) {
        struct rmap_assembly_shape *shape = &assembly->shape[i];
        char *path = mesh_path(folder, shape->file);
        if (!path)
            return no_memory(err);
        const char *trouble = rmap_input_file_trouble(path);
        uint64_t digest = 0;
        if (!trouble && !digest_of(path, &digest))
            trouble = "cannot be read";
        if (trouble || (shape->digest && digest != shape->digest)) {
            rmap_diagnostics_add(&assembly->findings, RMAP_SEVERITY_WARNING, 0, 0,
                                 RMAP_ASSEMBLY_MESHES
                                 "/%s is not as it was written (%s): made again",
                                 shape->file, trouble ? trouble : "other bytes");
            memset(shape->hash, '0', sizeof shape->hash - 1);
            shape->digest = 0;
        }
        rmap_free(path);
    }
    return RMAP_OK;
}

enum rmap_status rmap_model_read_stored(const char *folder, struct rmap_assembly *assembly,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    char *path = rmap_model_path(folder, STORED);
    if (!path)
        return no_memory(err);
    rmap_diagnostics_init(&assembly->findings, path);
    const char *trouble = rmap_input_file_trouble(path);
    if (trouble)
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE,
                                "%s is no folder that `raymap import` made of a model: %s: %s",
                                folder, path, trouble));
    st = rmap_input_file_read(path, RMAP_ASSEMBLY_NBYTES_MAX, &bytes, &nbytes, err);
    if (st == RMAP_OK)
        st = rmap_assembly_read_json((const char *)bytes, nbytes, assembly, err);
    if (st == RMAP_OK)
        st = rmap_assembly_settle_labels(assembly, err);
    if (st == RMAP_OK)
        st = forget_damaged(folder, assembly, err);
    if (st != RMAP_OK)
        rmap_error_context(err, "%s", path);
out:
    rmap_free(bytes);
    rmap_free(path);
    return st;
}

/* ---- writing ---- */

void rmap_model_stored_fini(struct rmap_model_stored *stored)
{
    for (size_t i = 0; i < sizeof stored->kept / sizeof *stored->kept; i++)
        rmap_free(stored->kept[i]);
}

static enum rmap_status put_json(const void *context, FILE *out, struct rmap_error *err)
{
    json_t *json = rmap_assembly_json(context);
    const bool good = json && !rmap_json_memory_failed() &&
                      json_dumpf(json, out, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) == 0 &&
                      !rmap_json_memory_failed();
    json_decref(json);
    (void)fputc('\n', out);
    return good ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for an assembly");
}

static enum rmap_status store_json(const char *folder, const struct rmap_assembly *assembly,
                                   struct rmap_error *err)
{
    char *path = rmap_model_path(folder, STORED);
    const enum rmap_status st =
        path ? rmap_whole_file_put(path, put_json, assembly, err) : no_memory(err);
    rmap_free(path);
    return st;
}

/* From where the converter made it, or from memory. */
static enum rmap_status store_mesh(const char *folder, const char *made,
                                   struct rmap_assembly_shape *shape, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *to = mesh_path(folder, shape->file),
         *from = made ? rmap_path_format("%s/" RMAP_MODEL_MADE "/%s", made, shape->made) : NULL;
    if (!to || (made && !from))
        st = no_memory(err);
    else if (shape->mesh)
        st = rmap_ply_write(shape->mesh, to, err);
    else if (!made || rename(from, to) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "mesh %s cannot be put in place: %s", to,
                            made ? strerror(errno) : "nobody made it");
    if (st == RMAP_OK && !digest_of(to, &shape->digest))
        st = rmap_error_set(err, RMAP_SYSTEM, "mesh %s cannot be read again: %s", to,
                            strerror(errno));
    rmap_free(to);
    rmap_free(from);
    return st;
}

static bool has_file(const struct rmap_assembly *assembly, const char *file)
{
    bool has = false;
    for (size_t i = 0; i < assembly->n_shape && !has; i++)
        has = strcmp(assembly->shape[i].file, file) == 0;
    return has;
}

static void remove_unused(const char *folder, const struct rmap_assembly *before,
                          const struct rmap_assembly *after, struct rmap_model_stored *stored)
{
    for (size_t i = 0; before && i < before->n_shape; i++) {
        char *path = has_file(after, before->shape[i].file)
                         ? NULL
                         : mesh_path(folder, before->shape[i].file);
        stored->n_mesh_removed += path && unlink(path) == 0;
        rmap_free(path);
    }
}

/* Until all meshes are there, those that are replaced are nobody's: an update that was killed is
 * then made good by the next one. */
static enum rmap_status announce(const char *folder, const struct rmap_assembly *after,
                                 const struct rmap_assembly_match *match, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char(*hash)[33] = rmap_alloc(after->n_shape, sizeof *hash);
    if (!hash)
        return no_memory(err);
    for (size_t i = 0; i < after->n_shape; i++) {
        memcpy(hash[i], after->shape[i].hash, sizeof *hash);
        if (!match->kept[i])
            memset(after->shape[i].hash, '0', 32);
    }
    st = store_json(folder, after, err);
    for (size_t i = 0; i < after->n_shape; i++)
        memcpy(after->shape[i].hash, hash[i], sizeof *hash);
    rmap_free(hash);
    return st;
}

static enum rmap_status store_meshes(const char *folder, const char *made,
                                     struct rmap_assembly *assembly,
                                     const struct rmap_assembly_match *match,
                                     struct rmap_model_stored *stored, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < assembly->n_shape && st == RMAP_OK; i++) {
        if (match && match->kept[i]) {
            stored->n_mesh_kept++;
            continue;
        }
        st = store_mesh(folder, made, &assembly->shape[i], err);
        stored->n_mesh_written += st == RMAP_OK;
    }
    return st;
}

/* with_user: the user's, too; without, those of them that are not there. */
static enum rmap_status store_texts(const char *folder, const struct rmap_assembly *assembly,
                                    bool with_user, bool force, struct rmap_model_stored *stored,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < N_TEXT && st == RMAP_OK; i++) {
        char *path = rmap_model_path(folder, text[i].name);
        if (!path)
            return no_memory(err);
        if (!text[i].of_user || with_user || access(path, F_OK) != 0)
            st = rmap_edits_put(path, force, text[i].put, assembly, &stored->kept[i], err);
        rmap_free(path);
    }
    return st;
}

enum rmap_status rmap_model_tell_missing(const char *folder, struct rmap_diagnostics *findings,
                                         struct rmap_error *err)
{
    for (size_t i = 0; i < N_TEXT; i++) {
        char *path = rmap_model_path(folder, text[i].name);
        if (!path)
            return no_memory(err);
        if (access(path, F_OK) != 0)
            rmap_diagnostics_add(findings, RMAP_SEVERITY_WARNING, 0, 0,
                                 "%s is not there any more: made anew, %s", text[i].name,
                                 text[i].of_user ? "without what you wrote in it" : "as always");
        rmap_free(path);
    }
    return RMAP_OK;
}

enum rmap_status rmap_model_store(const char *folder, const char *made,
                                  struct rmap_assembly *assembly,
                                  const struct rmap_assembly *before,
                                  const struct rmap_assembly_match *match, bool force,
                                  struct rmap_model_stored *stored, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *folder_of_meshes = rmap_model_path(folder, RMAP_ASSEMBLY_MESHES);
    if (!folder_of_meshes)
        return no_memory(err);
    RMAP_TRY(rmap_folder_make(folder_of_meshes, err));
    if (match)
        RMAP_TRY(announce(folder, assembly, match, err));
    RMAP_TRY(store_meshes(folder, made, assembly, match, stored, err));
    RMAP_TRY(store_texts(folder, assembly, match == NULL, force, stored, err));
    RMAP_TRY(store_json(folder, assembly, err));
    remove_unused(folder, before, assembly, stored);
out:
    rmap_free(folder_of_meshes);
    return st;
}
