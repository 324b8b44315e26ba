/* SPDX-License-Identifier: MIT
 *
 * Rays that come while a server answers: a trace into memory, slice by slice.
 */
#include "mpi/serve/serve_trace.h"

#include <stdio.h>
#include <string.h>

#include "io/map/map_content.h"
#include "io/map/map_held.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/serve/serve_scene.h"
#include "mpi/trace/trace_held.h"

/* What a question waits for at most, about; less at first, when who traces asks for a picture. */
static const double slice_s = 0.15, first_slice_s = 0.03, first_s = 0.15;

static const char *const state_name[] = {"none", "running", "paused", "done", "stopped", "failed"};

static uint64_t n_traced(const struct rmap_serve *self)
{
    return rmap_map_contents(self->map)->n_row[RMAP_TABLE_RAY];
}

json_t *rmap_serve_trace_json(const struct rmap_serve *self)
{
    const uint64_t n = n_traced(self);
    json_t *told =
        json_pack("{s:s, s:I, s:I, s:I, s:f, s:I, s:s*}", "state", state_name[self->state], "rays",
                  (json_int_t)n, "of", (json_int_t)(rmap_map_is_held(self->map) ? self->n_ray : n),
                  "seed", (json_int_t)self->seed, "seconds", self->seconds, "rays_taken_over",
                  (json_int_t)self->n_reused, "remark", rmap_serve_remark(self));
    if (told && self->state == RMAP_SERVE_FAILED)
        (void)json_object_set_new(told, "message", json_string(self->why));
    return told;
}

static void tell(struct rmap_serve *self)
{
    if (self->context.rank != 0)
        return;
    json_t *event = json_pack("{s:s}", "event", "trace");
    json_t *state = rmap_serve_trace_json(self);
    (void)json_object_update(event, state);
    json_decref(state);
    rmap_serve_event(self->queue, event);
}

/* What of the rays before the last edits the scene has, too. Those of a map on disk may be of
 * another instruction set, which decides ties between triangles. */
static enum rmap_status look_back(struct rmap_serve *self, struct rmap_error *err)
{
    struct rmap_map_summary last;
    if (!self->last)
        return RMAP_OK;
    rmap_map_summarise(self->last, &last);
    const bool is_same =
        rmap_map_is_held(self->last) || strcmp(last.isa, rmap_accel_isa(self->accel)) == 0;
    return last.seed == self->seed && is_same
               ? rmap_reuse_init(&self->reuse, self->last, 0, rmap_map_scene(self->map), err)
               : RMAP_OK;
}

/* Collective. */
static enum rmap_status start(struct rmap_serve *self, const json_t *message,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const json_t *rays = json_object_get(message, "rays"), *seed = json_object_get(message, "seed");
    const uint64_t now = json_is_integer(seed) ? (uint64_t)json_integer_value(seed) : 1;
    if (!json_is_integer(rays))
        return rmap_error_set(err, RMAP_USAGE, "trace wants how many in 'rays'");
    if (rmap_map_scene(self->map)->n_source == 0)
        return rmap_error_set(err, RMAP_INPUT, "the scene has no sources");
    if (!rmap_map_is_held(self->map) || n_traced(self) > 0 || now != self->seed)
        RMAP_TRY(rmap_serve_anew(self, now, err));
    if (!self->accel) {
        const struct rmap_scene *scene = rmap_map_scene(self->map);
        st = self->last_accel ? rmap_accel_create_like(self->last_accel, scene, &self->accel, err)
                              : rmap_accel_create_isa(scene, self->context.n_thread,
                                                      self->isa_level, &self->accel, err);
        RMAP_TRY(rmap_agree(&self->context, st, err));
    }
    rmap_reuse_fini(&self->reuse);
    RMAP_TRY(rmap_agree(&self->context, look_back(self, err), err));
    self->n_begun++;
    self->n_ray = (uint64_t)json_integer_value(rays);
    self->state = RMAP_SERVE_RUNNING;
    self->pace = self->seconds = 0.0;
    self->n_reused = 0;
out:
    return st;
}

static enum rmap_status act(struct rmap_serve *self, const json_t *message, const char *action,
                            struct rmap_error *err)
{
    const bool runs = self->state == RMAP_SERVE_RUNNING, rests = self->state == RMAP_SERVE_PAUSED;
    if (strcmp(action, "start") == 0)
        return start(self, message, err);
    if (strcmp(action, "pause") == 0 && (runs || rests))
        self->state = RMAP_SERVE_PAUSED;
    else if (strcmp(action, "resume") == 0 && (runs || rests))
        self->state = RMAP_SERVE_RUNNING;
    else if (strcmp(action, "stop") == 0 && (runs || rests))
        self->state = RMAP_SERVE_STOPPED;
    else if (strcmp(action, "pause") == 0 || strcmp(action, "resume") == 0 ||
             strcmp(action, "stop") == 0)
        return rmap_error_set(err, RMAP_INPUT, "no trace is going on");
    else
        return rmap_error_set(err, RMAP_USAGE, "'action' is start, pause, resume or stop");
    return RMAP_OK;
}

enum rmap_status rmap_serve_trace(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err)
{
    const char *action = json_string_value(json_object_get(message, "action"));
    const bool waits = json_is_true(json_object_get(message, "wait"));
    const json_t *begun = json_object_get(message, "begun"); /* it comes again, of that trace */
    enum rmap_status st = RMAP_OK;
    if (!begun)
        st = act(self, message, action ? action : "start", err);
    if (st != RMAP_OK)
        return st;
    if (!begun)
        tell(self);
    if (begun && (uint64_t)json_integer_value(begun) != self->n_begun)
        return rmap_error_set(err, RMAP_STOPPED,
                              "another request has begun another trace, or changed the scene");
    if (self->state == RMAP_SERVE_FAILED && begun)
        return rmap_error_set(err, RMAP_SYSTEM, "%s", self->why);
    self->again = waits && self->state == RMAP_SERVE_RUNNING;
    if (self->again && begun && self->at_hand.progressed && self->context.rank == 0)
        self->at_hand.progressed(self->at_hand.context,
                                 (double)n_traced(self) / (double)self->n_ray);
    if (!self->again)
        *result = rmap_serve_trace_json(self);
    else if (self->context.rank == 0 && self->request)
        (void)json_object_set_new(self->request->message, "begun",
                                  json_integer((json_int_t)self->n_begun));
    return RMAP_OK;
}

/* Collective. How far the next slice goes: rank 0 says, all hear. */
static enum rmap_status next_end(const struct rmap_serve *self, uint64_t *end_ret,
                                 struct rmap_error *err)
{
    const uint64_t done = n_traced(self), block = RMAP_BLOCK_RAYS;
    const uint64_t threads = (uint64_t)self->context.size * (uint64_t)self->context.n_thread;
    const double length = self->seconds < first_s ? first_slice_s : slice_s;
    uint64_t n = (uint64_t)(self->pace * length) / block * block;
    if (n < block * threads)
        n = block * (self->pace > 0.0 ? threads : 1);
    *end_ret = done + n < self->n_ray ? done + n : self->n_ray;
    return RMAP_MPI(MPI_Bcast(end_ret, 1, MPI_UINT64_T, 0, self->context.comm));
}

enum rmap_status rmap_serve_trace_slice(struct rmap_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_error why = {0};
    const uint64_t before = n_traced(self);
    const double begun = rmap_clock_seconds();
    uint64_t end = 0, reused = 0;
    RMAP_TRY(next_end(self, &end, err));
    enum rmap_status traced = rmap_trace_held_more(&self->context, self->accel, &self->reuse, end,
                                                   self->map, &self->seconds, &reused, &why);
    if (traced != RMAP_OK && self->reuse.n > 0 && !rmap_map_is_held(self->last)) {
        rmap_serve_forget_last(self); /* what lay on disk is gone or another: it is traced */
        reused = 0;
        traced = rmap_trace_held_more(&self->context, self->accel, &self->reuse, end, self->map,
                                      &self->seconds, &reused, &why);
    }
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &reused, 1, MPI_UINT64_T, MPI_SUM, self->context.comm)));
    self->n_reused += reused;
    const double passed = rmap_clock_seconds() - begun;
    self->pace = passed > 0.0 ? (double)(end - before) / passed : 0.0;
    if (traced != RMAP_OK) {
        self->state = RMAP_SERVE_FAILED;
        (void)snprintf(self->why, sizeof self->why, "%s", why.text);
    } else if (end == self->n_ray) {
        self->state = RMAP_SERVE_DONE;
    }
    tell(self);
out:
    return st;
}
