/* SPDX-License-Identifier: MIT
 *
 * The part of a trace between its start and its conclusion.
 */
#include "mpi/trace/trace_phase.h"
#include "io/map/map_space.h"
#include "io/write/shard_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_content.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/trace_session.h"

/* What one request is traced with, in its colour space. */
struct tools {
    struct rmap_bundle *options, bundle;
    const struct rmap_scene *scene;
    struct rmap_accel *accel; /* NULL: the session's */
    struct rmap_run run;
    struct rmap_forward *forward;
    struct rmap_shard_writer *writer;
};

/* Another colour space than the command line's: as the map has it. */
static enum rmap_status take_space(const struct rmap_trace_session *self, int32_t space,
                                   struct tools *tools, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = self->goal.map;
    tools->run = self->run;
    tools->scene = self->scene;
    if (space == self->goal.space)
        return RMAP_OK;
    RMAP_TRY(rmap_map_options_of(map, (size_t)space, &tools->options, err));
    tools->bundle = *rmap_map_bundle(map);
    tools->bundle.options = tools->options->options;
    tools->scene = rmap_map_scene_of(map, (size_t)space);
    tools->run.bundle = &tools->bundle;
    tools->run.scene = tools->scene;
    tools->run.space = space;
    RMAP_TRY(rmap_accel_create(tools->scene, self->context->n_thread, &tools->accel, err));
out:
    return st;
}

/* A node's own disk may hold other shards than the map's directory shows: numbers go on there. */
int rmap_trace_session_shard(const struct rmap_trace_session *self)
{
    const struct rmap_map *map = self->request.shard_dir ? self->goal.map : NULL;
    int first = 0;
    for (size_t k = 0; map && k < rmap_map_n_piece(map); k++)
        if (rmap_map_piece(map, k)->shard >= first)
            first = rmap_map_piece(map, k)->shard + 1;
    return first + self->context->rank;
}

/* Collective. */
static enum rmap_status open_shard(const struct rmap_trace_session *self, struct tools *tools,
                                   struct rmap_error *err)
{
    const struct rmap_trace_request *request = &self->request;
    const int shard = rmap_trace_session_shard(self);
    const struct rmap_map *map = self->goal.map;
    const struct rmap_shard_options options = {
        .first_piece = map ? rmap_map_content_next_number(rmap_map_contents(map), shard) : 0,
        .piece_nbytes = request->piece_nbytes,
        .flush_seconds = request->flush_s > 0.0 ? request->flush_s : RMAP_FLUSH_SECONDS,
        .flush_portions = request->flush_portions};
    const char *directory = request->shard_dir ? request->shard_dir : request->map_path;
    enum rmap_status st =
        rmap_forward_create(self->context, request->shards_per_node, &tools->forward, err);
    if (st == RMAP_OK && rmap_forward_writes(tools->forward))
        st = rmap_shard_writer_create(directory, shard, &tools->run, &options, &tools->writer, err);
    return rmap_agree(self->context, st, err);
}

/* Sums of one request join those of the others. */
static void merge_outcome(struct rmap_trace_session *self, struct rmap_trace_outcome *part)
{
    struct rmap_trace_outcome *all = &self->outcome;
    all->n_ray += part->n_ray;
    all->n_reused += part->n_reused;
    all->seconds += part->seconds;
    all->n_thread = part->n_thread;
    if (part->interrupt)
        all->interrupt = part->interrupt;
    if (part->survivors.missing > 0) {
        all->survivors = part->survivors;
        self->context = &all->survivors.context;
    }
    if (self->context->rank == 0 && all->tally)
        rmap_tally_merge(all->tally, part->tally);
    else if (self->context->rank == 0) {
        all->tally = part->tally;
        part->tally = NULL;
    }
    rmap_tally_destroy(part->tally);
}

static void tools_fini(struct tools *tools)
{
    rmap_shard_writer_destroy(tools->writer);
    rmap_forward_destroy(tools->forward);
    rmap_accel_destroy(tools->accel);
    rmap_bundle_destroy(tools->options);
}

enum rmap_status rmap_trace_phase_run(struct rmap_trace_session *self,
                                      const struct rmap_trace_phase *phase, bool recounts,
                                      struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    const struct rmap_trace_request *request = &self->request;
    struct tools tools = {0};
    struct rmap_trace_outcome outcome = {0};
    enum rmap_status st = take_space(self, phase->space, &tools, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (request->map_path && phase->rays.n > 0)
        RMAP_TRY(open_shard(self, &tools, err));
    struct rmap_trace_plan plan = {
        .scene = tools.scene,
        .accel = tools.accel ? tools.accel : self->accel,
        .seed = self->run.seed,
        .rays = &phase->rays,
        .deadline = request->time_limit_s > 0.0 ? self->begun + request->time_limit_s : 0.0,
        .writer = tools.writer,
        .forward = tools.forward,
        .reuse = self->from.in_use && phase->space == self->goal.space ? &self->from.reuse : NULL,
    };
    if (recounts && self->goal.n_recount > 0)
        plan.recount = (struct rmap_trace_recount){
            .map = self->goal.map, .portion = self->goal.recount, .n = self->goal.n_recount};
    if (self->until_tracing <= 0.0)
        self->until_tracing = rmap_clock_seconds() - self->begun;
    RMAP_TRY(rmap_trace_run(context, &plan, &outcome, err));
    merge_outcome(self, &outcome);
    if (request->map_path)
        RMAP_TRY(rmap_gather_content(self->context,
                                     tools.writer ? rmap_shard_writer_content(tools.writer) : NULL,
                                     &self->content, err));
out:
    tools_fini(&tools);
    return st;
}
