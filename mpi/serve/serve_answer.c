/* SPDX-License-Identifier: MIT
 *
 * What requests can be, and their answers: the server's own here, commands of the command line in
 * serve_command.c.
 */
#include "mpi/serve/serve_answer.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/map/map_held.h"
#include "mpi/parallel/agree.h"
#include "mpi/serve/serve_command.h"
#include "mpi/serve/serve_message.h"
#include "mpi/serve/serve_render.h"
#include "mpi/serve/serve_scene.h"
#include "mpi/serve/serve_trace.h"

typedef enum rmap_status answer(struct rmap_serve *self, const json_t *message, json_t **result,
                                struct rmap_error *err);

static answer answer_status, answer_quit, answer_check;

/* On every rank, to do or to refuse the same. keys: as rmap_serve_check_keys takes them; NULL: they
 * are those of the command line. */
static const struct {
    const char *name;
    answer *answer;
    const char *keys;
} own[] = {
    {"status", answer_status, ""},
    {"quit", answer_quit, ""},
    {"check", answer_check, NULL},
    {"load", rmap_serve_load, "file:s brief:b"},
    {"edit", rmap_serve_edit, "text:s set:o remove:l move:s by:l axes:s amend:n brief:b"},
    {"undo", rmap_serve_undo, "brief:b"},
    {"redo", rmap_serve_redo, "brief:b"},
    {"save", rmap_serve_save, "file:s force:b"},
    {"scene", rmap_serve_scene, "brief:b"},
    {"names", rmap_serve_names, ""},
    {"trace", rmap_serve_trace, "rays:p seed:n action:s wait:b"},
    {"render", rmap_serve_render, NULL},
};

enum { N_OWN = sizeof own / sizeof *own, WORDS_MAX = 64 };

static enum rmap_status answer_status(struct rmap_serve *self, const json_t *message,
                                      json_t **result, struct rmap_error *err)
{
    struct rmap_map_summary summary;
    char digest[33];
    (void)message;
    (void)err;
    rmap_map_summarise(self->map, &summary);
    rmap_digest_text(summary.digest, digest);
    *result =
        json_pack("{s:s, s:b, s:I, s:b, s:o, s:s, s:i, s:i}", "file", rmap_serve_file(self), "map",
                  (int)!rmap_map_is_held(self->map), "revision", (json_int_t)self->revision,
                  "saved", (int)(self->now == self->saved), "trace", rmap_serve_trace_json(self),
                  "digest", digest, "ranks", self->context.size, "threads", self->context.n_thread);
    return RMAP_OK;
}

static enum rmap_status answer_quit(struct rmap_serve *self, const json_t *message, json_t **result,
                                    struct rmap_error *err)
{
    (void)message;
    (void)err;
    self->quit = true;
    *result = json_object();
    return RMAP_OK;
}

/* Of the scene's text, or of another. A wrong one is no failure of the request. */
static enum rmap_status answer_check(struct rmap_serve *self, const json_t *message,
                                     json_t **result, struct rmap_error *err)
{
    const struct rmap_at_hand before = self->at_hand;
    const json_t *other = json_object_get(message, "text");
    const char *text = json_string_value(other);
    if (other && !text && !json_is_null(other))
        return rmap_error_set(err, RMAP_USAGE, "'text' of 'check' is a text");
    if (text) {
        self->at_hand.text = text;
        self->at_hand.root = NULL;
    }
    enum rmap_status st =
        rmap_serve_command_run(self, rmap_serve_command_find("check"), message, result, err);
    self->at_hand.text = before.text;
    self->at_hand.root = before.root;
    const bool told = st == RMAP_INPUT && json_object_get(self->details, "diagnostics");
    if (told) {
        *result = self->details;
        self->details = NULL;
    }
    return self->context.rank == 0 ? (told ? RMAP_OK : st) : st == RMAP_INPUT ? RMAP_OK : st;
}

static enum rmap_status refuse(const char *name, struct rmap_error *err)
{
    const char *word[WORDS_MAX];
    size_t n = 0;
    for (size_t i = 0; i < N_OWN; i++)
        word[n++] = own[i].name;
    for (size_t i = 0; rmap_serve_command_at(i) && n < WORDS_MAX; i++)
        word[n++] = rmap_serve_command_at(i)->name;
    const char *nearest = rmap_nearest_word(name, word, n);
    if (nearest)
        return rmap_error_set(err, RMAP_USAGE, "no command '%.60s' (did you mean '%s'?)", name,
                              nearest);
    return rmap_error_set(err, RMAP_USAGE, "no command '%.60s'", name);
}

static enum rmap_status find_answer(struct rmap_serve *self, const json_t *message, json_t **result,
                                    struct rmap_error *err)
{
    const char *name = json_string_value(json_object_get(message, "command"));
    for (size_t i = 0; name && i < N_OWN; i++)
        if (strcmp(name, own[i].name) == 0) {
            const enum rmap_status st =
                own[i].keys ? rmap_serve_check_keys(message, own[i].keys, err) : RMAP_OK;
            return st == RMAP_OK ? own[i].answer(self, message, result, err) : st;
        }
    const struct rmap_serve_command *known = name ? rmap_serve_command_find(name) : NULL;
    return known ? rmap_serve_command_run(self, known, message, result, err)
                 : refuse(name ? name : "", err);
}

/* Rank 0. */
static void respond(struct rmap_serve *self, enum rmap_status st, const struct rmap_error *why,
                    json_t *result)
{
    struct rmap_serve_request *request = self->request;
    self->request = NULL;
    if (!request) { /* a signal's */
        json_decref(result);
        return;
    }
    if (st == RMAP_OK && self->again && (request->state || !request->cancelled)) {
        rmap_serve_again(request);
        return;
    }
    if (request->cancelled) {
        json_decref(result);
        rmap_serve_answer(request, rmap_serve_error(request->message, RMAP_STOPPED, "cancelled"));
        return;
    }
    json_t *document = st == RMAP_OK ? rmap_serve_result(request->message, result)
                                     : rmap_serve_error(request->message, st, why->text);
    if (st != RMAP_OK && self->details)
        (void)json_object_update_missing(json_object_get(document, "error"), self->details);
    rmap_serve_answer(request, document);
}

enum rmap_status rmap_serve_answer_one(struct rmap_serve *self, const char *text,
                                       struct rmap_error *err)
{
    struct rmap_error why = {0};
    json_t *result = NULL, *message = json_loads(text, 0, NULL);
    self->again = false;
    enum rmap_status st = message ? RMAP_OK : rmap_error_set(&why, RMAP_SYSTEM, "out of memory");
    st = rmap_agree(&self->context, st, &why);
    if (st == RMAP_OK)
        st = find_answer(self, message, &result, &why);
    if (self->context.rank == 0)
        respond(self, st, &why, result);
    else
        json_decref(result);
    json_decref(self->details);
    self->details = NULL;
    json_decref(message);
    (void)err; /* whatever went wrong is told to who asked */
    return RMAP_OK;
}
