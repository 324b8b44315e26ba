/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/publish.h"
#include "mpi/command/balance.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/trace/trace_session.h"
#include "mpi/trace/trace_summary.h"

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
