/* SPDX-License-Identifier: MIT
 *
 * The text of a server's scene becomes a file, and those of its included files.
 */
#define _XOPEN_SOURCE 700 /* realpath */

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/scene/scene_include.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/save_below.h"
#include "mpi/serve/serve_scene.h"

bool rmap_serve_is_scene_name(const char *path)
{
    return rmap_output_is(path, ".yaml") || rmap_output_is(path, ".yml");
}

static bool folder_of(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    char *name = rmap_path_format("%.*s", slash ? (int)(slash - path) + 1 : 2, slash ? path : "./");
    const bool found = name && realpath(name, folder) != NULL;
    rmap_free(name);
    return found;
}

/* From the folder of one file to that of another, "../parts/"; rmap_free. "": it is the same. NULL:
 * one is not there. */
static char *way_between(const char *from, const char *to)
{
    char a[PATH_MAX], b[PATH_MAX], up[PATH_MAX] = "";
    size_t n = 0;
    if (!folder_of(from, a) || !folder_of(to, b))
        return NULL;
    for (size_t i = 0; i == 0 || (a[i - 1] && a[i - 1] == b[i - 1]); i++)
        if ((a[i] == '/' || !a[i]) && (b[i] == '/' || !b[i]))
            n = i; /* so far it is the same folder */
    for (const char *at = a + n; *at; at++)
        if (*at == '/' && at[1] && strlen(up) + 4 < sizeof up)
            (void)strcat(up, "../");
    const char *down = b + n + (b[n] == '/');
    return rmap_path_format("%s%s%s", up, down, *down ? "/" : "");
}

/* Rank 0. The text as it is to stand in that file; rmap_free. */
static enum rmap_status text_for(const struct rmap_serve *self, const char *path, char **text_ret,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *text = self->text[self->now].text;
    char *way = self->at_hand.is_map ? NULL : way_between(path, self->at_hand.path);
    if (way && *way)
        st = rmap_scene_text_lead(text, way, text_ret, err);
    else if (!(*text_ret = rmap_strdup(text)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    rmap_free(way);
    return st;
}

/* The file of a part of a scene that is stored there: beside it, but for those that stand elsewhere
 * and stay what they are. rmap_free. */
static char *file_of(const struct rmap_serve *self, const char *path,
                     const struct rmap_include_part *part, bool *elsewhere_ret)
{
    char *name = part->n_name > 0 ? rmap_path_format("%.*s", (int)part->n_name, part->name) : NULL;
    *elsewhere_ret = name && rmap_include_stands_elsewhere(name);
    char *file = part->n_name > 0
                     ? rmap_include_path(*elsewhere_ret ? self->at_hand.path : path, part)
                     : rmap_strdup(path);
    rmap_free(name);
    return file;
}

/* Rank 0. Whether the scene's files are as they were read or saved last; those that are gone are
 * written anew. */
static enum rmap_status check_stored(const struct rmap_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_include_part part;
    bool elsewhere;
    for (const char *at = self->stored; st == RMAP_OK && rmap_include_next(&at, &part);) {
        char *file = file_of(self, rmap_serve_file(self), &part, &elsewhere);
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
static enum rmap_status save_files(const struct rmap_serve *self, const char *path,
                                   const char *whole, bool force, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_include_part own, part;
    const char *at = whole;
    char *text = NULL, *file = NULL, *way = way_between(path, self->at_hand.path);
    bool elsewhere;
    (void)rmap_include_next(&at, &own);
    while (st == RMAP_OK && rmap_include_next(&at, &part)) {
        file = file_of(self, path, &part, &elsewhere);
        text = rmap_include_text(&part);
        if (!file || !text)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
        else if (rmap_include_is_stored(&part, file))
            st = RMAP_OK;
        else if (elsewhere && way && *way)
            st = rmap_error_set(err, RMAP_USAGE,
                                "%s stands outside of the scene's folder, and would have to be "
                                "another file for %s: save the scene in its own folder",
                                file, path);
        else if ((st = rmap_save_below(self->folder, file, text, force, err)) != RMAP_OK)
            rmap_error_context(err, "%.*s, which the scene includes, is saved with it",
                               (int)part.n_name, part.name);
        rmap_free(file);
        rmap_free(text);
    }
    rmap_free(way);
    if (st != RMAP_OK)
        return st;
    text = rmap_include_text(&own);
    st = text ? rmap_save_below(self->folder, path, text, force, err)
              : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    rmap_free(text);
    return st;
}

static const char *last_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* In whatever words. A file of another name is another one, or becomes it when one is saved. */
static bool is_same_file(const char *a, const char *b)
{
    char its[PATH_MAX], other[PATH_MAX];
    return strcmp(a, b) == 0 || (strcmp(last_of(a), last_of(b)) == 0 && folder_of(a, its) &&
                                 folder_of(b, other) && strcmp(its, other) == 0);
}

enum rmap_status rmap_serve_save(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *file = json_string_value(json_object_get(message, "file"));
    const char *own = rmap_serve_file(self), *path = file ? file : own;
    const bool force = json_is_true(json_object_get(message, "force"));
    const bool is_first =
        self->at_hand.is_map && !self->saved_as; /* it has no file of its own yet */
    const bool is_own = !is_first && is_same_file(path, own);
    char *text = NULL, *name = NULL;
    if (!rmap_serve_is_scene_name(path))
        st = rmap_error_set(err, RMAP_USAGE,
                            "save wants a name that ends in .yaml or .yml in 'file'");
    else if (!(name = rmap_strdup(path)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
    if (st == RMAP_OK && self->context.rank == 0) {
        if (is_own && !force)
            st = check_stored(self, err);
        if (st == RMAP_OK)
            st = text_for(self, path, &text, err);
        if (st == RMAP_OK)
            st = save_files(self, path, text, is_own || force, err);
    }
    RMAP_TRY(rmap_agree(&self->context, st, err));
    *result = json_pack("{s:s, s:I}", "file", path, "revision", (json_int_t)self->revision);
    if (!is_own && !is_first) /* a copy */
        goto out;
    if (is_first) {
        self->saved_as = name;
        name = NULL;
    }
    rmap_free(self->stored);
    self->stored = text;
    text = NULL;
    self->saved = self->now;
out:
    rmap_free(text);
    rmap_free(name);
    return st;
}
