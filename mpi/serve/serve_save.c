/* SPDX-License-Identifier: MIT
 *
 * The text of a server's scene becomes a file, and those of its included files.
 */
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/scene/scene_include.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/save_below.h"
#include "mpi/serve/serve_scene.h"

bool rmap_serve_is_scene_name(const char *path)
{
    return rmap_output_is(path, ".yaml") || rmap_output_is(path, ".yml");
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat one, other;
    return stat(a, &one) == 0 && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
           one.st_ino == other.st_ino;
}

/* Rank 0. Whether the scene's files are as they were read or saved last; those that are gone are
 * written anew. */
static enum rmap_status check_stored(const struct rmap_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_include_part part;
    for (const char *at = self->stored; st == RMAP_OK && rmap_include_next(&at, &part);) {
        char *file = part.n_name > 0 ? rmap_include_path(self->at_hand.path, &part)
                                     : rmap_strdup(self->at_hand.path);
        if (!file)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
        else if (access(file, F_OK) == 0 && !rmap_include_is_stored(&part, file))
            st = rmap_error_set(err, RMAP_USAGE,
                                "%s is no longer as it was read: another program has changed it; "
                                "'force': true replaces it",
                                file);
        rmap_free(file);
    }
    return st;
}

/* Rank 0. Files that the scene includes where they are other ones, then its own. */
static enum rmap_status save_files(const struct rmap_serve *self, const char *path, bool force,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_include_part own, part;
    const char *at = self->text[self->now].text;
    char *text = NULL, *file = NULL;
    (void)rmap_include_next(&at, &own);
    while (st == RMAP_OK && rmap_include_next(&at, &part)) {
        file = rmap_include_path(path, &part);
        text = rmap_include_text(&part);
        if (!file || !text)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
        else if (!rmap_include_is_stored(&part, file))
            st = rmap_save_below(self->folder, file, text, force, err);
        rmap_free(file);
        rmap_free(text);
    }
    if (st != RMAP_OK)
        return st;
    text = rmap_include_text(&own);
    st = text ? rmap_save_below(self->folder, path, text, force, err)
              : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    rmap_free(text);
    return st;
}

enum rmap_status rmap_serve_save(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *file = json_string_value(json_object_get(message, "file"));
    const bool is_own = !file || strcmp(file, self->at_hand.path) == 0;
    const char *path = file ? file : self->at_hand.path;
    if (!rmap_serve_is_scene_name(path))
        st = rmap_error_set(err, RMAP_USAGE,
                            "save wants a name that ends in .yaml or .yml in 'file'");
    const bool force = json_is_true(json_object_get(message, "force"));
    if (st == RMAP_OK && is_own && !force && self->context.rank == 0)
        st = check_stored(self, err);
    if (st == RMAP_OK && self->context.rank == 0)
        st = save_files(self, path, is_own || force, err);
    RMAP_TRY(rmap_agree(&self->context, st, err));
    if (is_own || is_same_file(path, self->at_hand.path))
        rmap_serve_note_stored(self);
    self->saved = self->now;
    *result = json_pack("{s:s, s:I}", "file", path, "revision", (json_int_t)self->revision);
out:
    return st;
}
