/* SPDX-License-Identifier: MIT
 *
 * The text of a server's scene becomes a file, and those of its included files.
 */
#include <string.h>

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
    if (st == RMAP_OK && self->context.rank == 0)
        st = save_files(self, path, is_own || json_is_true(json_object_get(message, "force")), err);
    RMAP_TRY(rmap_agree(&self->context, st, err));
    self->saved = self->now;
    *result = json_pack("{s:s, s:I}", "file", path, "revision", (json_int_t)self->revision);
out:
    return st;
}
