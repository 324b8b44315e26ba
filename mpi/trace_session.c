/* SPDX-License-Identifier: MIT */
#include "mpi/trace_session.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/map_directory.h"
#include "io/publish.h"
#include "mpi/agree.h"
#include "mpi/balance.h"
#include "mpi/gather_content.h"
#include "mpi/interrupt.h"
#include "mpi/load.h"
#include "mpi/progress.h"
#include "mpi/scene_difference.h"
#include "mpi/trace_summary.h"

/* What one request is traced with, in its colour space. */
struct tools {
    struct rmap_bundle *options, bundle;
    const struct rmap_scene *scene;
    struct rmap_accel *accel; /* NULL: the session's */
    struct rmap_run run;
    struct rmap_forward *forward;
    struct rmap_shard_writer *writer;
};

/* Collective. Bit-equal rays are promised per instruction set, so one run may have only one. */
static enum rmap_status check_isa(const struct rmap_context *context, const char *isa,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char first[32] = "";
    (void)snprintf(first, sizeof first, "%s", isa);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(first, sizeof first, MPI_CHAR, 0, context->comm)));
    if (strcmp(first, isa) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM,
                            "rank %d runs on %s but rank 0 on %s; run on nodes of one kind",
                            context->rank, isa, first);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Whether an index stands at the path. RMAP_FORMAT where pieces stand without one: they are not to
 * be lost. */
static enum rmap_status look_for_map(const char *path, int *stands, struct rmap_error *err)
{
    struct stat info;
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    char *index = rmap_path_format("%s/map.h5", path);
    if (!index)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    *stands = stat(index, &info) == 0;
    bool is_directory = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    rmap_free(index);
    if (*stands || !is_directory)
        return RMAP_OK;
    enum rmap_status st = rmap_map_list_pieces(path, &name, &n, err);
    rmap_free(name);
    if (st == RMAP_OK && n > 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s has pieces but no map.h5: raymap repair makes it again", path);
    return st;
}

/* Collective. Opens the map that is gone on with, if one stands. */
static enum rmap_status open_map(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    const char *path = self->request.map_path;
    enum rmap_status st = RMAP_OK;
    int stands = 0;
    if (context->rank == 0)
        st = look_for_map(path, &stands, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&stands, 1, MPI_INT, 0, context->comm)));
    if (!stands && self->request.mode == RMAP_TRACE_APPEND)
        st = rmap_error_set(err, RMAP_INPUT, "%s: there is no map to add to; leave out --append",
                            path);
    if (stands)
        st = rmap_map_open_untallied(path, &self->goal.map, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Says what differs rather than that something does. */
static enum rmap_status explain(const struct rmap_trace_session *self, enum rmap_status st,
                                struct rmap_error *err)
{
    struct rmap_error whole = *err;
    char what[128];
    if (st != RMAP_INPUT || !strstr(err->text, "another scene"))
        return st;
    rmap_scene_difference(rmap_map_bundle(self->goal.map), self->bundle, what, sizeof what);
    return rmap_error_set(err, st, "%s; the first difference: %s", whole.text, what);
}

/* Collective. */
static enum rmap_status find_goal(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->request.mode != RMAP_TRACE_NEW)
        RMAP_TRY(open_map(self, err));
    if (self->goal.map)
        st = explain(self, rmap_trace_goal_continue(&self->request, &self->run, &self->goal, err),
                     err);
    else
        st = rmap_trace_goal_begin(&self->request, &self->goal, err);
    RMAP_TRY(rmap_agree(self->context, st, err));
    self->run.space = self->goal.space;
out:
    return st;
}

/* Rank 0. The pieces that the map's index lists: only of them it has the sums. */
static enum rmap_status listed_content(const struct rmap_map *map, struct rmap_map_content *listed,
                                       struct rmap_error *err)
{
    const struct rmap_map_content *content = rmap_map_contents(map);
    enum rmap_status st = RMAP_OK;
    struct rmap_portion_info *portion =
        rmap_alloc(content->n_portion ? content->n_portion : 1, sizeof *portion);
    if (!portion)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
    for (size_t k = 0; st == RMAP_OK && k < content->n_piece; k++) {
        const struct rmap_piece_info *piece = &content->piece[k];
        size_t n = 0;
        for (size_t i = 0; i < content->n_portion; i++)
            if ((size_t)content->portion[i].piece == k && !content->portion[i].is_added)
                portion[n++] = content->portion[i];
        if (n > 0)
            st = rmap_map_content_add_piece(listed, piece, portion, n,
                                            content->chunk + piece->first_chunk, err);
    }
    rmap_free(portion);
    return st;
}

/* Rank 0. An index at the start: what a killed trace leaves says what was asked for. */
static enum rmap_status announce(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_goal *goal = &self->goal;
    struct rmap_map_content listed = {0};
    bool may_replace = self->request.force || self->request.mode == RMAP_TRACE_RESUME;
    if (!goal->map)
        RMAP_TRY(rmap_map_create(self->request.map_path, may_replace, err));
    else
        RMAP_TRY(listed_content(goal->map, &listed, err));
    const struct rmap_index index = {.run = &self->run,
                                     .before = goal->map,
                                     .row = &goal->row,
                                     .content = &listed,
                                     .tally = goal->map ? rmap_map_tally(goal->map) : NULL};
    RMAP_TRY(rmap_index_write_content(self->request.map_path, &index, err));
out:
    rmap_map_content_fini(&listed);
    return st;
}

enum rmap_status rmap_trace_session_begin(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    enum rmap_status st = rmap_accel_create(self->scene, context->n_thread, &self->accel, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(check_isa(context, rmap_accel_isa(self->accel), err));
    self->run = (struct rmap_run){.bundle = self->bundle,
                                  .scene = self->scene,
                                  .seed = self->request.seed,
                                  .n_rank = context->size,
                                  .encoding = self->request.encoding,
                                  .isa = rmap_accel_isa(self->accel),
                                  .embree_version = rmap_accel_embree_version()};
    RMAP_TRY(find_goal(self, err));
    self->goal.row.n_rank = context->size;
    if (self->request.map_path && context->rank == 0 && self->goal.has_row)
        st = announce(self, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

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
static int first_shard(const struct rmap_trace_session *self)
{
    int first = 0;
    if (!self->request.shard_dir || !self->goal.map)
        return 0;
    for (size_t k = 0; k < rmap_map_n_piece(self->goal.map); k++)
        if (rmap_map_piece(self->goal.map, k)->shard >= first)
            first = rmap_map_piece(self->goal.map, k)->shard + 1;
    return first;
}

/* Collective. */
static enum rmap_status open_shard(const struct rmap_trace_session *self, struct tools *tools,
                                   struct rmap_error *err)
{
    const struct rmap_trace_request *request = &self->request;
    const struct rmap_shard_options options = {
        .piece_nbytes = request->piece_nbytes,
        .flush_seconds = request->flush_s > 0.0 ? request->flush_s : RMAP_FLUSH_SECONDS,
        .flush_portions = request->flush_portions};
    const char *directory = request->shard_dir ? request->shard_dir : request->map_path;
    enum rmap_status st =
        rmap_forward_create(self->context, request->shards_per_node, &tools->forward, err);
    if (st == RMAP_OK && rmap_forward_writes(tools->forward))
        st = rmap_shard_writer_create(directory, first_shard(self) + self->context->rank,
                                      &tools->run, &options, &tools->writer, err);
    return rmap_agree(self->context, st, err);
}

/* Sums of one request join those of the others. */
static void merge_outcome(struct rmap_trace_session *self, struct rmap_trace_outcome *part)
{
    struct rmap_trace_outcome *all = &self->outcome;
    all->n_ray += part->n_ray;
    all->seconds += part->seconds;
    all->n_thread = part->n_thread;
    if (part->interrupt)
        all->interrupt = part->interrupt;
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

/* Collective. One request's missing rays; with the first of them, sums that nobody kept. */
static enum rmap_status trace_phase(struct rmap_trace_session *self, int32_t space,
                                    const struct rmap_ray_set *rays, bool recounts,
                                    struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    const struct rmap_trace_request *request = &self->request;
    struct tools tools = {0};
    struct rmap_trace_outcome outcome = {0};
    enum rmap_status st = take_space(self, space, &tools, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (request->map_path && rays->n > 0)
        RMAP_TRY(open_shard(self, &tools, err));
    struct rmap_trace_plan plan = {
        .scene = tools.scene,
        .accel = tools.accel ? tools.accel : self->accel,
        .seed = self->run.seed,
        .rays = rays,
        .deadline = request->time_limit_s > 0.0 ? self->begun + request->time_limit_s : 0.0,
        .writer = tools.writer,
        .forward = tools.forward,
    };
    if (recounts && self->goal.n_recount > 0)
        plan.recount = (struct rmap_trace_recount){
            .map = self->goal.map, .portion = self->goal.recount, .n = self->goal.n_recount};
    RMAP_TRY(rmap_trace_run(context, &plan, &outcome, err));
    merge_outcome(self, &outcome);
    if (request->map_path)
        RMAP_TRY(rmap_gather_content(context,
                                     tools.writer ? rmap_shard_writer_content(tools.writer) : NULL,
                                     &self->content, err));
out:
    tools_fini(&tools);
    return st;
}

/* Nothing to trace, nothing to sum up, and the index says so. */
static bool is_idle(const struct rmap_trace_goal *goal)
{
    struct rmap_map_summary summary = {0};
    if (goal->map)
        rmap_map_summarise(goal->map, &summary);
    return summary.complete && goal->n_missing == 0;
}

enum rmap_status rmap_trace_session_run(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_goal *goal = &self->goal;
    const struct rmap_ray_set none = {0};
    uint64_t due = 0;
    if (is_idle(goal)) {
        st = rmap_tally_create(self->scene, &self->outcome.tally, err);
        return rmap_agree(self->context, st, err);
    }
    self->outcome.n_wanted = goal->n_missing;
    for (size_t i = 0; i < goal->n_phase && self->outcome.n_ray == due; i++) {
        const struct rmap_trace_phase *phase = &goal->phase[i];
        RMAP_TRY(trace_phase(self, phase->space, &phase->rays, i == 0, err));
        due += rmap_ray_set_count(&phase->rays);
    }
    if (goal->n_phase == 0)
        RMAP_TRY(trace_phase(self, goal->space, &none, true, err));
out:
    return st;
}

/* Rank 0. The map's index, with all that it holds now. */
static enum rmap_status write_index(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_trace_goal *goal = &self->goal;
    const struct rmap_index index = {.run = &self->run,
                                     .before = goal->map,
                                     .row = goal->has_row ? &goal->row : NULL,
                                     .content = &self->content,
                                     .tally = self->outcome.tally,
                                     .complete = self->outcome.n_ray == goal->n_missing};
    enum rmap_status st = RMAP_OK;
    if (goal->map) /* what was there already, unfinished pieces left out by the index */
        st = rmap_map_content_add(&self->content, rmap_map_contents(goal->map), err);
    return st == RMAP_OK ? rmap_index_write_content(self->request.map_path, &index, err) : st;
}

/* Rank 0. */
static enum rmap_status finish(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_plan plan = {
        .scene = self->scene, .accel = self->accel, .seed = self->run.seed};
    const struct rmap_trace_report report = {.plan = &plan,
                                             .outcome = &self->outcome,
                                             .map_path = self->request.map_path,
                                             .n_held = self->goal.n_held};
    if (self->goal.map)
        rmap_tally_merge(self->outcome.tally, rmap_map_tally(self->goal.map));
    RMAP_TRY(rmap_balance_check(self->outcome.tally, err));
    if (is_idle(&self->goal) && !self->context->quiet)
        fprintf(stderr, "raymap: %s is complete: nothing was left to trace\n",
                self->request.map_path);
    else if (self->request.map_path && !is_idle(&self->goal))
        RMAP_TRY(write_index(self, err));
    RMAP_TRY(rmap_trace_summarise(self->context, &report, err));
out:
    return st;
}

enum rmap_status rmap_trace_session_conclude(struct rmap_trace_session *self,
                                             struct rmap_error *err)
{
    const struct rmap_trace_outcome *outcome = &self->outcome;
    enum rmap_status st = self->context->rank == 0 ? finish(self, err) : RMAP_OK;
    if (st == RMAP_OK && outcome->n_ray < outcome->n_wanted)
        st = rmap_error_set(
            err, RMAP_STOPPED, "stopped early by %s: %llu of %llu rays traced%s",
            outcome->interrupt ? rmap_interrupt_name(outcome->interrupt) : "the time limit",
            (unsigned long long)outcome->n_ray, (unsigned long long)outcome->n_wanted,
            self->request.map_path ? "; the map holds them, and --resume traces the rest" : "");
    return rmap_agree(self->context, st, err);
}

void rmap_trace_session_fini(struct rmap_trace_session *self)
{
    rmap_tally_destroy(self->outcome.tally);
    rmap_map_content_fini(&self->content);
    rmap_trace_goal_fini(&self->goal);
    rmap_accel_destroy(self->accel);
    rmap_scene_destroy(self->scene);
    rmap_bundle_destroy(self->bundle);
}
