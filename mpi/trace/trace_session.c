/* SPDX-License-Identifier: MIT
 *
 * A run of `raymap trace` from the loaded scene to the finished index: what the map lacks is
 * found, traced request by request, and told.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/map_chunks.h"
#include "io/map/map_directory.h"
#include "io/write/index_writer.h"
#include "mpi/command/balance.h"
#include "mpi/command/load.h"
#include "mpi/command/scene_difference.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/recover.h"
#include "mpi/trace/trace_phase.h"
#include "mpi/trace/trace_session.h"
#include "mpi/trace/trace_summary.h"

/* Whether an index stands at the path. RMAP_FORMAT where pieces stand without one: they are not to
 * be lost. */
static enum rmap_status look_for_map(const char *path, int *stands, struct rmap_error *err)
{
    struct stat info, directory;
    char *index = rmap_path_format("%s/map.h5", path);
    if (!index)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    enum rmap_status st = rmap_path_look(index, &info, err);
    if (st == RMAP_OK)
        st = rmap_path_look(path, &directory, err);
    rmap_free(index);
    *stands = st == RMAP_OK && info.st_mode != 0;
    if (st != RMAP_OK || *stands || !S_ISDIR(directory.st_mode))
        return st;
    return rmap_map_check_indexless(path, err);
}

/* Rank 0. The index is believed about what rays there are, so its pieces must be there; with a
 * shard directory they wait to be collected. */
static enum rmap_status check_pieces(const struct rmap_trace_session *self, struct rmap_error *err)
{
    struct rmap_error why = {0};
    if (self->request.shard_dir)
        return RMAP_OK;
    enum rmap_status st = rmap_map_check_pieces(self->goal.map, &why);
    if (st == RMAP_FORMAT)
        return rmap_error_set(err, st,
                              "%s; bring it back, or raymap repair gives its rays up and --resume "
                              "traces them again",
                              why.text);
    return st == RMAP_OK ? st : rmap_error_set(err, st, "%s", why.text);
}

/* What light a map counted is added to; sums that are wrong already are its damage, not ours. */
static enum rmap_status check_light(const struct rmap_map *map, const char *path,
                                    struct rmap_error *err)
{
    struct rmap_error why = {0};
    if (rmap_balance_check(rmap_map_tally(map), &why) == RMAP_OK)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: its energy balance does not add up: raymap verify says where, and "
                          "raymap repair counts its rays again",
                          path);
}

/* As others are told of it. */
static const char *command_of(const struct rmap_trace_request *request)
{
    return request->mode == RMAP_TRACE_APPEND   ? "trace --append"
           : request->mode == RMAP_TRACE_RESUME ? "trace --resume"
                                                : "trace";
}

/* Collective. Opens the map that is gone on with, if one stands. */
static enum rmap_status open_map(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    const char *path = self->request.map_path;
    enum rmap_status st = RMAP_OK;
    int stands = 0;
    if (context->rank == 0)
        st = rmap_map_lock_take(path, command_of(&self->request), &self->lock, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = look_for_map(path, &stands, err);
    if (st == RMAP_OK && stands) /* it may have come since */
        st = rmap_map_lock_take(path, command_of(&self->request), &self->lock, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&stands, 1, MPI_INT, 0, context->comm)));
    if (!stands && self->request.mode == RMAP_TRACE_APPEND)
        st = rmap_error_set(err, RMAP_INPUT, "%s: there is no map to add to; leave out --append",
                            path);
    RMAP_TRY(rmap_agree(context, st, err));
    if (!stands)
        goto out;
    RMAP_TRY(rmap_recover_wait(context, path, &self->found, err));
    RMAP_TRY(rmap_load_map_found(context, path, &self->found, &self->goal.map, err));
    if (rmap_map_selection(self->goal.map))
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s holds rays that a query picked (raymap info says which): nothing "
                            "can be traced into it; go on with the map that was asked",
                            path);
    if (st == RMAP_OK)
        st = check_light(self->goal.map, path, err);
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

/* Rank 0. Pieces that are left out: their rays are traced again. */
static void tell_trouble(const struct rmap_trace_session *self)
{
    for (size_t i = 0; i < rmap_map_n_trouble(self->goal.map); i++)
        fprintf(stderr,
                "raymap: warning: left out: %s; its rays are traced again, raymap repair takes it "
                "away\n",
                rmap_map_trouble(self->goal.map, i));
}

/* Collective. What killed writers left becomes finished pieces. */
static enum rmap_status recover_map(struct rmap_trace_session *self, struct rmap_error *err)
{
    const char *path = self->request.map_path;
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary summary;
    rmap_map_summarise(self->goal.map, &summary);
    if (!summary.complete)
        return rmap_recover(self->context, self->goal.map, &self->found, err);
    if (self->context->rank == 0)
        st = rmap_map_remove_spent_journals(path, &self->found, err);
    return rmap_agree(self->context, st, err);
}

/* Collective. Ranks read the index one after the other; of one that changes meanwhile each would
 * make a plan of its own, and rays would be traced twice or never. */
static enum rmap_status agree_on_plan(const struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_goal *goal = &self->goal;
    struct rmap_map_summary summary;
    rmap_map_summarise(goal->map, &summary);
    const uint64_t mine[] = {goal->n_missing,    goal->n_phase,       goal->n_recount,
                             goal->n_held,       goal->row.first_ray, summary.digest.low,
                             summary.digest.high};
    enum { N = sizeof mine / sizeof *mine };
    uint64_t first[N];
    memcpy(first, mine, sizeof mine);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(first, N, MPI_UINT64_T, 0, self->context->comm)));
    if (memcmp(first, mine, sizeof mine) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s is being written to by somebody else: try later",
                            self->request.map_path);
    RMAP_TRY(rmap_agree(self->context, st, err));
out:
    return st;
}

/* Collective. */
static enum rmap_status find_goal(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->goal.map) {
        st = rmap_trace_goal_begin(&self->request, &self->goal, err);
        return rmap_agree(self->context, st, err);
    }
    st = rmap_trace_goal_admit(&self->request, &self->run, &self->goal, err);
    RMAP_TRY(rmap_agree(self->context, explain(self, st, err), err));
    if (self->context->rank == 0)
        st = check_pieces(self, err);
    RMAP_TRY(rmap_agree(self->context, st, err));
    RMAP_TRY(recover_map(self, err));
    if (self->context->rank == 0)
        tell_trouble(self);
    RMAP_TRY(rmap_agree(self->context, rmap_trace_goal_plan(&self->goal, err), err));
    RMAP_TRY(agree_on_plan(self, err));
    self->run.space = self->goal.space;
out:
    return st;
}

/* Portions of the index, those of a piece together: first[k] is where piece k's begin. */
static void group_portions(const struct rmap_map_content *content, size_t *first,
                           struct rmap_portion_info *grouped)
{
    for (size_t i = 0; i < content->n_portion; i++)
        first[content->portion[i].piece + 1] += !content->portion[i].is_added;
    for (size_t k = 0; k < content->n_piece; k++)
        first[k + 1] += first[k];
    for (size_t i = 0; i < content->n_portion; i++) /* leaves each piece's end in first */
        if (!content->portion[i].is_added)
            grouped[first[content->portion[i].piece]++] = content->portion[i];
    for (size_t k = content->n_piece; k > 0; k--)
        first[k] = first[k - 1];
    first[0] = 0;
}

/* Rank 0. The pieces that the map's index lists: only of them it has the sums. */
static enum rmap_status listed_content(const struct rmap_map *map, struct rmap_map_content *listed,
                                       struct rmap_error *err)
{
    const struct rmap_map_content *content = rmap_map_contents(map);
    enum rmap_status st = RMAP_OK;
    size_t *first = rmap_alloc(content->n_piece + 1, sizeof *first);
    struct rmap_portion_info *grouped = rmap_alloc(content->n_portion + 1, sizeof *grouped);
    if (!first || !grouped) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of pieces");
        goto out;
    }
    group_portions(content, first, grouped);
    for (size_t k = 0; k < content->n_piece; k++)
        if (first[k + 1] > first[k])
            RMAP_TRY(rmap_map_content_add_piece(
                listed, &content->piece[k], grouped + first[k], first[k + 1] - first[k],
                content->chunk + content->piece[k].first_chunk, err));
out:
    rmap_free(grouped);
    rmap_free(first);
    return st;
}

/* Rank 0. What a job left that died before it had an index is in the way of no resume; what came
 * since this one looked is another's. */
static enum rmap_status create_map(struct rmap_trace_session *self, struct rmap_error *err)
{
    const char *path = self->request.map_path;
    bool may_replace =
        self->request.force || (self->request.mode == RMAP_TRACE_RESUME && self->lock.path);
    enum rmap_status st =
        rmap_map_create(path, may_replace, command_of(&self->request), &self->lock, err);
    if (st != RMAP_USAGE || may_replace)
        return st;
    return rmap_error_set(err, st,
                          "%s exists already: --resume or --append goes on with it, --force "
                          "replaces it, or use another name",
                          path);
}

/* Rank 0. An index at the start: what a killed trace leaves says what was asked for. */
static enum rmap_status announce(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_goal *goal = &self->goal;
    struct rmap_map_content listed = {0};
    if (!goal->map)
        RMAP_TRY(create_map(self, err));
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

/* A scene is the same under any file's name: it takes the one that the map knows it by. */
static enum rmap_status rename_scene(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_bundle *known = self->goal.map ? rmap_map_bundle(self->goal.map) : NULL;
    return rmap_bundle_rename(self->bundle, known && known->path ? known->path : RMAP_SCENE_NAME,
                              err);
}

enum rmap_status rmap_trace_session_begin(struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary summary = {0};
    if (self->request.mode != RMAP_TRACE_NEW)
        RMAP_TRY(open_map(self, err));
    st = rename_scene(self, err);
    RMAP_TRY(rmap_agree(context, st, err));
    summary = self->from.summary;
    if (self->goal.map)
        rmap_map_summarise(self->goal.map, &summary);
    RMAP_TRY(rmap_load_accel(context, self->scene, summary.isa, &self->accel, err));
    self->run = (struct rmap_run){.bundle = self->bundle,
                                  .scene = self->scene,
                                  .seed = self->request.seed,
                                  .n_rank = context->size,
                                  .encoding = self->request.encoding,
                                  .isa = rmap_accel_isa(self->accel),
                                  .embree_version = rmap_accel_embree_version()};
    RMAP_TRY(find_goal(self, err));
    if (self->goal.n_missing > 0 && self->request.map_path)
        RMAP_TRY(rmap_trace_from_decide(context, &self->from, self->scene, self->run.isa,
                                        self->run.seed, err));
    if (self->from.in_use)
        memcpy(self->parent, self->from.digest, sizeof self->parent);
    else if (self->goal.map)
        memcpy(self->parent, summary.parent, sizeof self->parent);
    self->run.parent = self->parent;
    self->goal.row.n_rank = context->size;
    if (self->request.map_path && self->request.shard_dir)
        st = rmap_shard_check_place(self->request.shard_dir, rmap_trace_session_shard(self),
                                    !self->goal.map, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (self->request.map_path && context->rank == 0 && self->goal.has_row)
        st = announce(self, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Rank 0. How many rays the map has more than before, the silent rank's by its journal. */
static uint64_t count_traced(const struct rmap_trace_session *self)
{
    struct rmap_error ignored = {0};
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary = {0};
    if (!self->request.map_path ||
        rmap_map_open_untallied(self->request.map_path, &map, &ignored) != RMAP_OK)
        return self->outcome.n_ray;
    rmap_map_summarise(map, &summary);
    rmap_map_close(map);
    return summary.n_row[RMAP_TABLE_RAY] - self->goal.n_held;
}

/* A full disk, or another failure of the system: what is not lost. */
static void tell_safe(const struct rmap_trace_session *self, struct rmap_error *err)
{
    const struct rmap_error why = *err;
    const struct rmap_trace_goal *goal = &self->goal;
    char safe[RMAP_GROUPED_LEN];
    if (self->context->rank != 0 || !self->request.map_path || self->request.shard_dir)
        return;
    (void)rmap_error_set(
        err, why.status, "%.640s; %s of %s are safe in %.200s, and --resume traces the rest",
        why.text, rmap_grouped(goal->n_held + count_traced(self), safe),
        rmap_counted(goal->n_held + goal->n_missing, "ray").text, self->request.map_path);
}

enum rmap_status rmap_trace_session_run(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_goal *goal = &self->goal;
    const struct rmap_trace_phase nothing = {.space = goal->space};
    uint64_t due = 0;
    if (rmap_trace_goal_is_idle(goal)) {
        st = rmap_tally_create(self->scene, &self->outcome.tally, err);
        return rmap_agree(self->context, st, err);
    }
    self->outcome.n_wanted = goal->n_missing;
    for (size_t i = 0;
         i < goal->n_phase && self->outcome.n_ray == due && self->outcome.survivors.missing == 0;
         i++) {
        const struct rmap_trace_phase *phase = &goal->phase[i];
        RMAP_TRY(rmap_trace_phase_run(self, phase, i == 0, err));
        due += rmap_ray_set_count(&phase->rays);
    }
    if (goal->n_phase == 0)
        RMAP_TRY(rmap_trace_phase_run(self, &nothing, true, err));
out:
    if (st == RMAP_SYSTEM)
        tell_safe(self, err);
    return st;
}

void rmap_trace_session_fini(struct rmap_trace_session *self)
{
    rmap_tally_destroy(self->outcome.tally);
    rmap_map_content_fini(&self->content);
    rmap_trace_goal_fini(&self->goal);
    rmap_trace_from_fini(&self->from);
    rmap_map_listing_fini(&self->found);
    rmap_map_lock_release(&self->lock);
    rmap_accel_destroy(self->accel);
    rmap_scene_destroy(self->scene);
    rmap_bundle_destroy(self->bundle);
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
    if (self->outcome.survivors.missing > 0 && goal->n_recount > 0)
        return RMAP_OK; /* sums that the silent rank has: the index of the start stays */
    if (goal->map)      /* what was there already, unfinished pieces left out by the index */
        st = rmap_map_content_add(&self->content, rmap_map_contents(goal->map), err);
    return st == RMAP_OK ? rmap_index_write_content(self->request.map_path, &index, err) : st;
}

/* Rank 0. What the index that was written just now lists, and how large all of it is. */
static enum rmap_status sum_up(struct rmap_trace_session *self, struct rmap_trace_report *report,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat index;
    char *path = rmap_path_format("%s/map.h5", self->request.map_path);
    if (!path || stat(path, &index) != 0) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: map.h5 cannot be examined: %s",
                            self->request.map_path, strerror(errno));
        goto out;
    }
    report->content = &self->content;
    report->map_nbytes = (uint64_t)index.st_size;
    RMAP_TRY(rmap_map_content_drop_open(&self->content, err));
    RMAP_TRY(rmap_map_content_sort(&self->content, err));
    RMAP_TRY(rmap_map_content_check(&self->content, path, err));
    for (size_t i = 0; i < self->content.n_piece; i++)
        report->map_nbytes += self->content.piece[i].nbytes;
out:
    rmap_free(path);
    return st;
}

/* Rank 0. */
static enum rmap_status finish(struct rmap_trace_session *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_plan plan = {
        .scene = self->scene, .accel = self->accel, .seed = self->run.seed};
    struct rmap_map_summary summary = {0};
    struct rmap_trace_report report = {.plan = &plan,
                                       .outcome = &self->outcome,
                                       .map_path = self->request.map_path,
                                       .n_held = self->goal.n_held,
                                       .from = self->from.map ? &self->from : NULL,
                                       .from_path = self->request.from_path,
                                       .until_tracing = self->until_tracing};
    if (self->goal.map)
        rmap_tally_merge(self->outcome.tally, rmap_map_tally(self->goal.map));
    RMAP_TRY(rmap_balance_check(self->outcome.tally, err));
    if (rmap_trace_goal_is_idle(&self->goal)) {
        rmap_map_summarise(self->goal.map, &summary);
        report.content = rmap_map_contents(self->goal.map);
        report.map_nbytes = summary.nbytes;
        if (!self->context->quiet)
            fprintf(stderr, "raymap: %s is complete: nothing was left to trace\n",
                    self->request.map_path);
    } else if (self->request.map_path) {
        RMAP_TRY(write_index(self, err));
        RMAP_TRY(sum_up(self, &report, err));
    }
    RMAP_TRY(rmap_trace_summarise(self->context, &report, err));
out:
    return st;
}

/* Rank 0, when a rank does not answer: nothing is left that all ranks could do together. */
static void end_without(struct rmap_trace_session *self, enum rmap_status st,
                        const struct rmap_error *error)
{
    const struct rmap_survivors *survivors = &self->outcome.survivors;
    fprintf(stderr, "raymap: %s; rank %d on %s did not answer\n", error->text, survivors->missing,
            survivors->host);
    (void)fflush(stdout);
    rmap_map_lock_release(&self->lock);
    (void)MPI_Abort(survivors->context.comm, (int)st);
}

/* Rank 0. More than that share of the map's rays ended in an error: what it says of the rest may be
 * of another scene than the one that was meant. */
static enum rmap_status check_errors(const struct rmap_trace_session *self, struct rmap_error *err)
{
    const double most = 1e-3;
    const struct rmap_tally *tally = self->outcome.tally;
    double errors = 0.0, emitted = 0.0;
    for (size_t s = 0; s < tally->scene->n_source; s++) {
        errors += tally->error[s];
        emitted += tally->emitted[s];
    }
    if (!(errors > most * emitted))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_LOST,
                          "%.3g %% of the rays ended in an error, more than %g %%%s; raymap report "
                          "SCENE --ray %llu shows the first",
                          100.0 * errors / emitted, 100.0 * most,
                          self->request.map_path ? " (the map is whole and kept)" : "",
                          (unsigned long long)tally->first_error_ray);
}

enum rmap_status rmap_trace_session_conclude(struct rmap_trace_session *self,
                                             struct rmap_error *err)
{
    const struct rmap_trace_outcome *outcome = &self->outcome;
    enum rmap_status st = self->context->rank == 0 ? finish(self, err) : RMAP_OK;
    char traced[RMAP_GROUPED_LEN];
    uint64_t n_traced = outcome->n_ray;
    bool missing = outcome->survivors.missing > 0;
    if (st == RMAP_OK && missing && self->context->rank == 0)
        n_traced = count_traced(self);
    if (st == RMAP_OK && (missing || n_traced < outcome->n_wanted))
        st = rmap_error_set(
            err, RMAP_STOPPED, "stopped early by %s: %s of %s traced%s",
            outcome->interrupt ? rmap_interrupt_name(outcome->interrupt) : "the time limit",
            rmap_grouped(n_traced, traced), rmap_counted(outcome->n_wanted, "ray").text,
            self->request.map_path ? "; the map holds them, and --resume traces the rest" : "");
    if (st == RMAP_OK && self->context->rank == 0)
        st = check_errors(self, err);
    st = rmap_agree(self->context, st, err);
    if (missing && self->context->rank == 0)
        end_without(self, st, err);
    return st;
}
