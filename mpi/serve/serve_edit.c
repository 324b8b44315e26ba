/* SPDX-License-Identifier: MIT
 *
 * What the request of an edit makes of a scene's text.
 */
#include "mpi/serve/serve_edit.h"

#include <string.h>

#include "base/alloc.h"
#include "scene/scene_edit.h"

/* The number of the text that an edit changes: that of now, or where it takes the place of the last
 * one (`amend`) what that one changed. */
static enum rmap_status base_of(const struct rmap_serve *self, const json_t *amend,
                                size_t *base_ret, struct rmap_error *err)
{
    *base_ret = self->now;
    if (!amend || json_is_null(amend))
        return RMAP_OK;
    if (self->now == 0 || self->edited != self->revision ||
        (uint64_t)json_integer_value(amend) != self->revision)
        return rmap_error_set(err, RMAP_INPUT,
                              "the scene is no longer that of the edit to amend: edit it anew");
    *base_ret = self->now - 1;
    return RMAP_OK;
}

/* The detector that lies on something and goes elsewhere. Where its place before an edit that is
 * amended is known no more, that is refused. */
static enum rmap_status find_lying(const struct rmap_serve *self, const char *move, bool amends,
                                   struct rmap_serve_lying *lying, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    lying->detector = -1;
    for (size_t d = 0; move && d < scene->n_detector; d++)
        if (rmap_detector_lies_on(&scene->detector[d]) &&
            strcmp(scene->detector[d].name, move) == 0)
            *lying = (struct rmap_serve_lying){(int32_t)d, scene->detector[d].origin};
    if (!amends || lying->detector < 0)
        return RMAP_OK;
    if (self->lying.detector != lying->detector)
        return rmap_error_set(err, RMAP_INPUT,
                              "the edit to amend did not move '%.100s': undo it, and move anew",
                              move);
    *lying = self->lying;
    return RMAP_OK;
}

static bool has(const json_t *message, const char *key)
{
    const json_t *value = json_object_get(message, key);
    return value && !json_is_null(value);
}

/* The text that an edit of `now` leads to. */
static enum rmap_status edited(const struct rmap_serve *self, struct rmap_scene_text *now,
                               const json_t *message, const struct rmap_serve_lying *lying,
                               struct rmap_scene_text *text_ret, struct rmap_error *err)
{
    const json_t *text = json_object_get(message, "text"), *set = json_object_get(message, "set"),
                 *remove = json_object_get(message, "remove");
    const char *move = json_string_value(json_object_get(message, "move"));
    const bool sets = has(message, "set") || has(message, "remove"),
               moves = move || has(message, "by") || has(message, "axes");
    if (has(message, "text") + sets + moves > 1)
        return rmap_error_set(err, RMAP_USAGE,
                              "edit takes 'text', or 'set' and 'remove', or 'move' and 'by': one "
                              "of these in a request");
    if (json_is_string(text)) {
        text_ret->text = rmap_strdup(json_string_value(text));
        return text_ret->text ? RMAP_OK
                              : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a text");
    }
    if (json_is_object(set) || json_is_array(remove))
        return rmap_scene_text_change(now, remove, set, text_ret, err);
    if (move) {
        const struct rmap_affine frame = rmap_scene_frame_of(rmap_map_scene(self->map), move);
        const char *axes = json_string_value(json_object_get(message, "axes"));
        const bool world = axes && strcmp(axes, "world") == 0;
        if (!world && axes && strcmp(axes, "own") != 0)
            return rmap_error_set(err, RMAP_USAGE, "'axes' is \"own\" or \"world\"");
        return rmap_scene_text_move(now, move, json_object_get(message, "by"),
                                    world ? &frame : NULL,
                                    lying->detector < 0 ? NULL : &lying->place, text_ret, err);
    }
    return rmap_error_set(
        err, RMAP_USAGE,
        "edit wants a 'text', or keys and values in 'set' and a list of keys in 'remove', or an "
        "object's name in 'move' and how far in 'by'");
}

enum rmap_status rmap_serve_edited(const struct rmap_serve *self, const json_t *message,
                                   size_t *base_ret, struct rmap_serve_lying *lying_ret,
                                   struct rmap_scene_text *text_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(base_of(self, json_object_get(message, "amend"), base_ret, err));
    RMAP_TRY(find_lying(self, json_string_value(json_object_get(message, "move")),
                        *base_ret != self->now, lying_ret, err));
    RMAP_TRY(edited(self, &self->text[*base_ret], message, lying_ret, text_ret, err));
    text_ret->is_move = json_is_string(json_object_get(message, "move"));
out:
    return st;
}
