/* SPDX-License-Identifier: MIT
 *
 * The scene of a server: read, edited as text, undone and saved. The text is the truth: every
 * change is one of it, and the scene is what it says.
 */
#include "mpi/serve/serve_scene.h"

#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_word.h"
#include "analysis/page/page_parts.h"
#include "analysis/query/map_light.h"
#include "base/alloc.h"
#include "io/map/map_content.h"
#include "io/map/map_held.h"
#include "io/map/map_space.h"
#include "io/mesh/bundle_pack.h"
#include "io/scene/scene_text.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/serve_edit.h"
#include "mpi/session/session_words.h"
#include "portion/event.h"
#include "trace/tracer_revision.h"

enum { UNDO_MAX = 1000 };

const char *rmap_serve_file(const struct rmap_serve *self)
{
    return self->saved_as ? self->saved_as : self->at_hand.path;
}

const char *rmap_serve_remark(const struct rmap_serve *self)
{
    return self->is_mixed ? "the map has several colour spaces: new rays are in its first" : NULL;
}

void rmap_serve_forget_last(struct rmap_serve *self)
{
    rmap_reuse_fini(&self->reuse);
    rmap_accel_destroy(self->last_accel);
    rmap_map_close(self->last);
    self->last_accel = NULL;
    self->last = NULL;
}

static uint64_t n_ray_of(const struct rmap_map *map)
{
    return map ? rmap_map_contents(map)->n_row[RMAP_TABLE_RAY] : 0;
}

/* Whether the map has more to give to the rays of the next than that of before: the seed that was
 * asked for last is the one that will be. */
static bool has_more_to_give(const struct rmap_map *map, const struct rmap_map *last)
{
    struct rmap_map_summary its, before;
    if (!map || n_ray_of(map) == 0 || rmap_map_selection(map))
        return false;
    rmap_map_summarise(map, &its);
    if (!rmap_map_is_held(map) && its.tracer_revision != RMAP_TRACER_REVISION)
        return false;
    if (!last)
        return true;
    rmap_map_summarise(last, &before);
    return its.seed != before.seed || n_ray_of(map) >= n_ray_of(last);
}

/* The map and its structure step aside for another; they are kept where they have more to give to
 * its rays than those of before. */
static void put_map(struct rmap_serve *self, struct rmap_map *map)
{
    if (self->reuse.touch.change.all[0]) /* an edit that is undone makes them useful again */
        self->n_useless++;
    else if (self->reuse.n > 0)
        self->n_useless = 0;
    const bool gives = has_more_to_give(self->map, self->n_useless > 1 ? NULL : self->last);
    if (self->accel) {
        rmap_accel_destroy(self->last_accel);
        self->last_accel = self->accel;
        self->accel = NULL;
    }
    rmap_reuse_fini(&self->reuse);
    rmap_map_close(gives ? self->last : self->map);
    if (gives) {
        self->last = self->map;
        self->n_useless = 0;
    }
    self->map = self->at_hand.map = map;
}

/* The map is another from now on; NULL: none. */
static void take_map(struct rmap_serve *self, struct rmap_map *map)
{
    put_map(self, map);
    self->state = RMAP_SERVE_NONE;
    self->n_ray = self->n_reused = 0;
    self->seconds = 0.0;
    self->n_begun++;
    self->revision++;
}

static void drop_texts_from(struct rmap_serve *self, size_t first)
{
    for (size_t i = first; i < self->n_text; i++)
        rmap_scene_text_fini(&self->text[i]);
    if (self->n_text > first)
        self->n_text = first;
    if (self->saved != SIZE_MAX && self->saved >= first)
        self->saved = SIZE_MAX; /* what was saved cannot be come back to */
}

void rmap_serve_scene_fini(struct rmap_serve *self)
{
    take_map(self, NULL);
    rmap_serve_forget_last(self);
    drop_texts_from(self, 0);
    rmap_free(self->text);
    rmap_free(self->stored);
    rmap_free(self->saved_as);
    rmap_bundle_destroy(self->bundle);
    rmap_free((char *)(uintptr_t)self->at_hand.path);
}

/* The scene is what that text of the list says. */
static void look_at(struct rmap_serve *self, size_t number)
{
    const struct rmap_scene_text *text = &self->text[number];
    self->now = number;
    self->at_hand.text = text->text;
    self->at_hand.root = text->is_sound ? text->root : NULL;
}

/* Behind the one that is now; those that were undone go. Takes the text over on success. Trees are
 * kept of what the next edit may change: this text, or the one before. */
static enum rmap_status push_text(struct rmap_serve *self, struct rmap_scene_text *text,
                                  struct rmap_error *err)
{
    const enum rmap_status st = RMAP_RESERVE(self->text, self->cap_text, self->n_text + 1, err);
    if (st != RMAP_OK)
        return st;
    drop_texts_from(self, self->n_text > 0 ? self->now + 1 : 0);
    if (self->n_text > UNDO_MAX) { /* the scene itself, and its changes */
        rmap_scene_text_fini(&self->text[0]);
        memmove(self->text, self->text + 1, (self->n_text - 1) * sizeof *self->text);
        self->n_text--;
        self->saved = self->saved == 0 || self->saved == SIZE_MAX ? SIZE_MAX : self->saved - 1;
    }
    for (size_t i = 0; i + 1 < self->n_text; i++) {
        rmap_yaml_destroy(self->text[i].root);
        self->text[i].root = NULL;
    }
    self->text[self->n_text] = *text;
    *text = (struct rmap_scene_text){0};
    look_at(self, self->n_text++);
    return RMAP_OK;
}

/* What takes the place of the scene and of its rays. */
struct opening {
    struct rmap_map *map;
    struct rmap_bundle *bundle;
    struct rmap_scene_text text;
    char *path;
};

static void opening_fini(struct opening *opened)
{
    rmap_map_close(opened->map);
    rmap_bundle_destroy(opened->bundle);
    rmap_scene_text_fini(&opened->text);
    rmap_free(opened->path);
}

/* Collective. The scene of at_hand.text, with no rays yet; its text is with those of the files that
 * it includes. */
static enum rmap_status build(struct rmap_serve *self, uint64_t seed, struct opening *opened,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options options = {.read_map = rmap_map_light_read};
    struct rmap_diagnostics found;
    struct rmap_scene *scene = NULL;
    rmap_diagnostics_init(&found, self->at_hand.path);
    RMAP_TRY(rmap_load_scene_told(&self->context, self->at_hand.path, &options, &found,
                                  &opened->bundle, &scene, err));
    st = rmap_map_hold(self->context.size, seed, scene, &opened->map, err);
    if (st == RMAP_OK)
        scene = NULL;
    st = rmap_agree(&self->context, st, err);
    if (st == RMAP_OK) {
        opened->text.text = opened->bundle->text;
        opened->bundle->text = NULL;
    }
out:
    if (st != RMAP_OK && self->context.rank == 0 && found.n > 0)
        self->details = json_pack("{s:o, s:s}", "diagnostics", rmap_json_diagnostics(&found),
                                  "file", self->at_hand.path);
    rmap_diagnostics_fini(&found);
    rmap_scene_destroy(scene);
    return st;
}

static void put_bundle(struct rmap_serve *self, struct opening *opened)
{
    rmap_bundle_destroy(self->bundle);
    self->at_hand.bundle = self->bundle = opened->bundle;
    opened->bundle = NULL;
}

enum rmap_status rmap_serve_anew(struct rmap_serve *self, uint64_t seed, struct rmap_error *err)
{
    struct opening opened = {0};
    const enum rmap_status st = build(self, seed, &opened, err);
    if (st == RMAP_OK) {
        put_bundle(self, &opened);
        put_map(self, opened.map);
        opened.map = NULL;
        self->seed = seed;
    }
    opening_fini(&opened);
    return st;
}

/* Collective. The text of a scene's file, as rank 0 reads it. */
static enum rmap_status read_text(const struct rmap_serve *self, const char *path, char **text_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *bundle = NULL;
    uint8_t *blob = NULL;
    size_t n = 0;
    if (self->context.rank == 0)
        st = rmap_bundle_open(path, NULL, &bundle, err);
    if (bundle) {
        n = bundle->text_nbytes + 1;
        blob = (uint8_t *)bundle->text;
        bundle->text = NULL;
    }
    RMAP_TRY(rmap_agree(&self->context, st, err));
    RMAP_TRY(rmap_broadcast_blob(&self->context, &blob, &n, err));
    *text_ret = (char *)blob;
    blob = NULL;
out:
    rmap_free(blob);
    rmap_bundle_destroy(bundle);
    return st;
}

/* Collective. */
static enum rmap_status open_map(const struct rmap_serve *self, struct opening *opened,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *first = NULL;
    RMAP_TRY(rmap_load_map(&self->context, opened->path, &opened->map, err));
    struct rmap_bundle bundle = *rmap_map_bundle(opened->map); /* its options: the last trace's */
    st = rmap_map_options_of(opened->map, 0, &first, err);
    if (st == RMAP_OK) {
        bundle.options = first->options;
        st = rmap_bundle_share(&bundle, bundle.text, NULL, &opened->bundle, err);
    }
    if (st == RMAP_OK && !(opened->text.text = rmap_strdup(bundle.text)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    st = rmap_agree(&self->context, st, err);
out:
    rmap_bundle_destroy(first);
    return st;
}

/* Collective. */
static enum rmap_status open_scene(struct rmap_serve *self, struct opening *opened,
                                   struct rmap_error *err)
{
    char *own = NULL;
    enum rmap_status st = read_text(self, opened->path, &own, err);
    RMAP_TRY(st);
    self->at_hand.path = opened->path;
    self->at_hand.text = own;
    self->at_hand.root = NULL;
    self->at_hand.bundle = NULL;
    self->at_hand.is_map = false;
    self->context.at_hand = &self->at_hand;
    st = build(self, self->seed, opened, err);
out:
    rmap_free(own);
    return st;
}

enum rmap_status rmap_serve_open(struct rmap_serve *self, const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_at_hand before = self->at_hand;
    struct opening opened = {.path = rmap_strdup(path)};
    const bool is_scene = rmap_serve_is_scene_name(path);
    if (!opened.path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
    RMAP_TRY(rmap_agree(&self->context, st, err));
    self->context.at_hand = NULL; /* it is a file that is opened, whatever its name */
    st = is_scene ? open_scene(self, &opened, err) : open_map(self, &opened, err);
    self->context.at_hand = &self->at_hand;
    RMAP_TRY(st);
    drop_texts_from(self, 0);
    st = rmap_agree(&self->context, push_text(self, &opened.text, err), err);
    RMAP_TRY(st);
    self->is_mixed = rmap_map_n_space(opened.map) > 1;
    take_map(self, opened.map);
    opened.map = NULL;
    rmap_serve_forget_last(self);
    put_bundle(self, &opened);
    self->at_hand.path = opened.path;
    opened.path = NULL;
    self->at_hand.is_map = !is_scene;
    rmap_free((char *)(uintptr_t)before.path);
    self->saved = 0;
    rmap_free(self->saved_as);
    self->saved_as = NULL;
    rmap_free(self->stored);
    self->stored =
        is_scene && self->context.rank == 0 ? rmap_strdup(self->text[self->now].text) : NULL;
    if (!is_scene)
        self->state = RMAP_SERVE_DONE;
    return RMAP_OK;
out:
    self->at_hand = before;
    opening_fini(&opened);
    return st;
}

static void tell_change(struct rmap_serve *self)
{
    if (self->context.rank == 0)
        rmap_serve_event(self->queue, json_pack("{s:s, s:I}", "event", "scene", "revision",
                                                (json_int_t)self->revision));
}

/* With the text, unless the answer is to be brief; takes `places`, NULL: it does without. */
static json_t *state_of(const struct rmap_serve *self, const json_t *message, json_t *places)
{
    const bool brief = json_is_true(json_object_get(message, "brief"));
    return json_pack("{s:I, s:I, s:I, s:b, s:s, s:s*, s:o*, s:s*}", "revision",
                     (json_int_t)self->revision, "undo", (json_int_t)self->now, "redo",
                     (json_int_t)(self->n_text - self->now - 1), "saved",
                     (int)(self->now == self->saved), "file", rmap_serve_file(self), "text",
                     brief ? NULL : self->text[self->now].text, "places", places, "remark",
                     rmap_serve_remark(self));
}

enum rmap_status rmap_serve_load(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    const char *path = json_string_value(json_object_get(message, "file"));
    if (!path)
        return rmap_error_set(err, RMAP_USAGE, "load wants the name of a scene or map in 'file'");
    const enum rmap_status st = rmap_serve_open(self, path, err);
    if (st != RMAP_OK)
        return st;
    tell_change(self);
    *result = state_of(self, message, NULL);
    return RMAP_OK;
}

/* Collective. The scene becomes that of the text, which gets those of the files that it includes.
 * is_move: nothing but places changes by it, and rank 0 gets those. */
static enum rmap_status change(struct rmap_serve *self, struct rmap_scene_text *text, bool is_move,
                               json_t **places_ret, struct rmap_error *err)
{
    const struct rmap_at_hand before = self->at_hand;
    struct opening opened = {0};
    self->at_hand.text = text->text;
    self->at_hand.root = text->is_sound ? text->root : NULL;
    const enum rmap_status st = build(self, self->seed, &opened, err);
    self->at_hand.text = before.text;
    self->at_hand.root = before.root;
    if (st == RMAP_OK) {
        if (is_move && self->context.rank == 0)
            *places_ret = rmap_page_places(rmap_map_scene(self->map), rmap_map_scene(opened.map));
        put_bundle(self, &opened);
        take_map(self, opened.map);
        opened.map = NULL;
        if (strcmp(text->text, opened.text.text) != 0) {
            opened.text.is_move = text->is_move;
            rmap_scene_text_fini(text);
            *text = opened.text;
            opened.text = (struct rmap_scene_text){0};
        }
    }
    opening_fini(&opened);
    return st;
}

enum rmap_status rmap_serve_edit(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    struct rmap_scene_text text = {0};
    json_t *places = NULL;
    struct rmap_serve_lying lying;
    size_t base;
    enum rmap_status st = rmap_serve_edited(self, message, &base, &lying, &text, err);
    RMAP_TRY(rmap_agree(&self->context, st, err));
    if (strcmp(text.text, self->text[self->now].text) == 0) {
        if (base == self->now) /* the revision of the answer is that of an edit before */
            self->edited = UINT64_MAX;
        *result = state_of(self, message, NULL);
        goto out;
    }
    RMAP_TRY(change(self, &text,
                    text.is_move && (base == self->now || self->text[self->now].is_move), &places,
                    err));
    self->now = base;
    st = rmap_agree(&self->context, push_text(self, &text, err), err);
    RMAP_TRY(st);
    self->edited = self->revision;
    self->lying = lying;
    tell_change(self);
    *result = state_of(self, message, json_incref(places));
out:
    json_decref(places);
    rmap_scene_text_fini(&text);
    return st;
}

/* To another text of the list. */
static enum rmap_status go(struct rmap_serve *self, size_t to, const json_t *message,
                           json_t **result, struct rmap_error *err)
{
    json_t *places = NULL;
    const bool is_move = self->text[to > self->now ? to : self->now].is_move;
    const enum rmap_status st = change(self, &self->text[to], is_move, &places, err);
    if (st != RMAP_OK)
        return st;
    look_at(self, to);
    tell_change(self);
    *result = state_of(self, message, places);
    return RMAP_OK;
}

enum rmap_status rmap_serve_undo(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    if (self->now == 0)
        return rmap_error_set(err, RMAP_INPUT, "there is nothing to undo");
    return go(self, self->now - 1, message, result, err);
}

enum rmap_status rmap_serve_redo(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err)
{
    if (self->now + 1 >= self->n_text)
        return rmap_error_set(err, RMAP_INPUT, "there is nothing to redo");
    return go(self, self->now + 1, message, result, err);
}

enum rmap_status rmap_serve_scene(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err)
{
    (void)err;
    *result = state_of(self, message, NULL);
    (void)json_object_update(*result, rmap_session_names_json(rmap_map_scene(self->map)));
    return RMAP_OK;
}

enum rmap_status rmap_serve_names(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err)
{
    json_t *words = json_array(), *values = json_array(), *events = json_array();
    (void)message;
    (void)err;
    for (size_t i = 0; rmap_criterion_word(i); i++)
        (void)json_array_append_new(words, json_string(rmap_criterion_word(i)));
    for (int place = 1; rmap_stats_word(place); place++)
        (void)json_array_append_new(values, json_sprintf("%s%s", rmap_stats_word(place)->word,
                                                         rmap_stats_word(place)->wants ? "(" : ""));
    for (uint32_t bit = 1; rmap_event_word(bit); bit <<= 1)
        (void)json_array_append_new(events, json_string(rmap_event_word(bit)));
    *result = rmap_session_names_json(rmap_map_scene(self->map));
    (void)json_object_set_new(*result, "words", words);
    (void)json_object_set_new(*result, "values", values);
    (void)json_object_set_new(*result, "events", events);
    return RMAP_OK;
}
