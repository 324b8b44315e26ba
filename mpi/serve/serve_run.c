/* SPDX-License-Identifier: MIT
 *
 * A server: requests of many clients, answered one after the other by all ranks. Between two of
 * them a trace that is going on gets on by a slice.
 */
#include "mpi/serve/serve_run.h"

#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/progress.h"
#include "mpi/serve/serve_answer.h"
#include "mpi/serve/serve_browser.h"
#include "mpi/serve/serve_capture.h"
#include "mpi/serve/serve_http.h"
#include "mpi/serve/serve_lines.h"
#include "mpi/serve/serve_message.h"
#include "mpi/serve/serve_picture.h"
#include "mpi/serve/serve_render.h"
#include "mpi/serve/serve_scene.h"
#include "mpi/serve/serve_trace.h"

enum { IDLE_MS = 200 };

/* Of rank 0: what leads in. */
struct doors {
    struct rmap_serve_lines *lines, *socket;
    struct rmap_serve_http *http;
    int out;    /* what standard output was */
    bool alone; /* standard input is the one way in */
};

static const double waits_s = 0.15; /* a trace, at most, for requests; about what a slice takes */
static const char slice_text[] = "{}"; /* what other ranks are told of a slice */

/* Collective. Rank 0's text on every rank; the others wait asleep. rmap_free. */
static enum rmap_status share(const struct rmap_context *context, const char *text, char **text_ret,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *blob = context->rank == 0 ? (uint8_t *)rmap_strdup(text) : NULL;
    size_t n = context->rank == 0 ? strlen(text) + 1 : 0;
    if (context->rank == 0 && !blob)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a request");
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &n, err));
    *text_ret = (char *)blob;
    blob = NULL;
out:
    rmap_free(blob);
    return st;
}

static void progressed(void *context, double part)
{
    const struct rmap_serve *self = context;
    if (self->request)
        rmap_serve_tell(self->request, json_pack("{s:O?, s:s, s:f}", "id",
                                                 json_object_get(self->request->message, "id"),
                                                 "event", "progress", "progress", part));
}

/* Rank 0: the next text for all ranks; NULL: there is nothing to do just now. */
static char *next_text(struct rmap_serve *self, const struct doors *doors)
{
    const bool runs = self->state == RMAP_SERVE_RUNNING;
    if (rmap_interrupt_caught())
        return rmap_strdup("{\"command\": \"quit\"}");
    if (runs && rmap_clock_seconds() - self->sliced > waits_s)
        return rmap_strdup(slice_text);
    self->request = rmap_serve_queue_next(self->queue, runs ? 0 : IDLE_MS);
    if (self->request && self->request->cancelled && self->request->state) {
        rmap_interrupt_stop_question(); /* its next step, which releases what it has */
    } else if (self->request && self->request->cancelled) {
        rmap_serve_answer(self->request,
                          rmap_serve_error(self->request->message, RMAP_STOPPED, "cancelled"));
        self->request = NULL;
        return NULL;
    }
    if (self->request)
        return rmap_serve_text(self->request->message);
    if (runs)
        return rmap_strdup(slice_text);
    if (doors->alone && rmap_serve_lines_done(doors->lines))
        return rmap_strdup("{\"command\": \"quit\"}");
    return NULL;
}

/* Collective. A request, or a slice of the trace; one, too, before a request comes again. */
static enum rmap_status serve_one(struct rmap_serve *self, const char *text, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->again = strcmp(text, slice_text) == 0;
    if (!self->again) {
        rmap_serve_cancel_begin(self->cancel);
        st = rmap_serve_answer_one(self, text, err);
        rmap_serve_cancel_end(self->cancel);
    }
    if (st != RMAP_OK || !self->again || self->state != RMAP_SERVE_RUNNING)
        return st;
    rmap_interrupt_forget(); /* that was for the request, not for the trace */
    st = rmap_serve_trace_slice(self, err);
    self->sliced = rmap_clock_seconds();
    return st;
}

/* Collective. */
static enum rmap_status serve(struct rmap_serve *self, const struct doors *doors,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (st == RMAP_OK && !self->quit) {
        char *own = NULL, *text = NULL;
        while (self->context.rank == 0 && !(own = next_text(self, doors)))
            continue;
        st = share(&self->context, own, &text, err);
        if (st == RMAP_OK)
            st = serve_one(self, text, err);
        rmap_free(own);
        rmap_free(text);
    }
    return st;
}

/* Rank 0. One line, so that who started the program can read how to talk to it. */
static enum rmap_status tell_ready(const struct doors *doors, const struct rmap_serve_ways *ways,
                                   struct rmap_error *err)
{
    json_t *told = json_pack("{s:s}", "event", "ready");
    char url[128];
    if (doors->http) {
        (void)snprintf(url, sizeof url, "%s/?token=%s", rmap_serve_http_address(doors->http),
                       rmap_serve_http_token(doors->http));
        (void)json_object_set_new(told, "url", json_string(url));
        (void)json_object_set_new(told, "address",
                                  json_string(rmap_serve_http_address(doors->http)));
        (void)json_object_set_new(told, "token", json_string(rmap_serve_http_token(doors->http)));
    }
    if (ways->socket)
        (void)json_object_set_new(told, "socket", json_string(ways->socket));
    char *text = rmap_serve_text(told);
    json_decref(told);
    const bool done = text && dprintf(doors->out, "%s\n", text) > 0;
    rmap_free(text);
    if (!done)
        return rmap_error_set(err, RMAP_SYSTEM, "the address cannot be told on standard output");
    if (doors->http && ways->browser)
        rmap_serve_browser(url);
    return RMAP_OK;
}

/* Rank 0. */
static enum rmap_status open_doors(struct rmap_serve *self, const struct rmap_serve_ways *ways,
                                   struct doors *doors, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char folder[PATH_MAX];
    self->folder = getcwd(folder, sizeof folder) ? rmap_strdup(folder) : NULL;
    if (!self->folder)
        return rmap_error_set(err, RMAP_SYSTEM, "this folder has no path");
    (void)signal(SIGPIPE, SIG_IGN); /* clients go as they like */
    RMAP_TRY(rmap_serve_capture_begin(&self->capture, &doors->out, err));
    RMAP_TRY(rmap_serve_queue_create(&self->queue, err));
    if (ways->socket)
        RMAP_TRY(rmap_serve_socket_start(self->queue, ways->socket, &doors->socket, err));
    if (ways->http)
        RMAP_TRY(rmap_serve_http_start(self->queue, ways->port, &doors->http, err));
    if (ways->socket || ways->http)
        RMAP_TRY(tell_ready(doors, ways, err));
    if (ways->lines)
        RMAP_TRY(rmap_serve_lines_start(self->queue, STDIN_FILENO, doors->out, &doors->lines, err));
    doors->alone = ways->lines && !ways->socket && !ways->http;
out:
    return st;
}

static void close_doors(struct rmap_serve *self, struct doors *doors)
{
    rmap_serve_queue_close(self->queue);
    rmap_serve_lines_stop(doors->lines);
    rmap_serve_lines_stop(doors->socket);
    rmap_serve_http_stop(doors->http);
    rmap_serve_queue_destroy(self->queue);
    if (doors->out >= 0) {
        (void)fflush(stdout);
        (void)dup2(doors->out, STDOUT_FILENO);
        (void)close(doors->out);
    }
    if (self->capture >= 0)
        (void)close(self->capture);
    rmap_free(self->folder);
}

enum rmap_status rmap_serve_run(const struct rmap_context *context, const char *path,
                                const struct rmap_serve_ways *ways, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct doors doors = {.out = -1};
    struct rmap_serve self = {.context = *context, .capture = -1, .seed = 1, .saved = SIZE_MAX};
    self.context.json = self.context.quiet = true;
    self.context.at_hand = &self.at_hand;
    self.at_hand.progressed = progressed;
    self.at_hand.context = &self;
    RMAP_TRY(rmap_common_isa(context, &self.isa_level, err));
    RMAP_TRY(rmap_serve_open(&self, path, err));
    if (rmap_serve_remark(&self) && context->rank == 0 && !context->quiet)
        fprintf(stderr, "raymap: %s: %s\n", path, rmap_serve_remark(&self));
    RMAP_TRY(rmap_serve_cancel_start(context, &self.cancel, err));
    if (context->rank == 0)
        st = open_doors(&self, ways, &doors, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(serve(&self, &doors, err));
    if (context->rank == 0 && rmap_interrupt_caught())
        st = rmap_error_set(err, RMAP_STOPPED, "stopped by %s",
                            rmap_interrupt_name(rmap_interrupt_caught()));
    st = rmap_agree(context, st, err);
out:
    if (self.details && context->rank == 0) { /* the scene that was to be served is wrong */
        char *text = rmap_serve_text(self.details);
        fprintf(stderr, "%s\n", text ? text : "");
        rmap_free(text);
    }
    json_decref(self.details);
    rmap_serve_cancel_finish(self.cancel);
    if (context->rank == 0)
        close_doors(&self, &doors);
    rmap_serve_picture_fini(&self);
    rmap_serve_render_fini(&self);
    rmap_serve_scene_fini(&self);
    return st;
}
