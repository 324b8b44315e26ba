/* SPDX-License-Identifier: MIT
 *
 * A picture, rendered on all ranks in passes over its tiles.
 */
#include "mpi/trace/render_run.h"

#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"
#include "mpi/trace/render_pass.h"

/* 1, 1, 2, 4, 8, 16, 16, ...: the first picture comes soon, and later ones seldom. */
static uint64_t pass_samples(uint64_t done, uint64_t wanted)
{
    const uint64_t most = 16;
    uint64_t n = done == 0 ? 1 : done < most ? done : most;
    return n < wanted - done ? n : wanted - done;
}

/* Collective. Each pixel is one rank's, and zero on the others: the sum is exact in any order. */
static enum rmap_status gather(const struct rmap_context *context, struct rmap_film *film,
                               struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 24;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < film->n_value && context->size > 1; at += piece) {
        int n = (int)(film->n_value - at < piece ? film->n_value - at : piece);
        void *mine = film->value + at;
        const void *from = context->rank == 0 ? MPI_IN_PLACE : mine;
        RMAP_TRY(RMAP_MPI(MPI_Reduce(from, mine, n, MPI_DOUBLE, MPI_SUM, 0, context->comm)));
    }
out:
    return st;
}

/* Collective. Sums and outcomes that every rank needs alike. */
struct tidings {
    uint64_t n_tile;
    bool late; /* by rank 0's clock */
    int interrupt;
    bool dropped; /* nobody wants the picture any longer */
};

static enum rmap_status tell(const struct rmap_context *context, struct rmap_render_pass *pass,
                             struct rmap_render_outcome *outcome, struct tidings *tidings,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_render_counts *c = &pass->counts;
    uint64_t sum[6] = {c->n_path, c->n_segment, c->n_look, c->n_limit, c->n_error, pass->n_tile};
    int stop[3] = {rmap_interrupt_caught(), context->rank == 0 && tidings->late,
                   rmap_interrupt_stops_question()};
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 6, MPI_UINT64_T, MPI_SUM, context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, stop, 3, MPI_INT, MPI_MAX, context->comm)));
    *c = (struct rmap_render_counts){sum[0], sum[1], sum[2], sum[3], sum[4]};
    *tidings = (struct tidings){sum[5], stop[1] != 0, stop[0], stop[2] != 0};
    outcome->interrupt = stop[0];
out:
    return st;
}

/* Collective. Pass after pass, until there are enough, or no more time. */
static enum rmap_status run_passes(const struct rmap_context *context,
                                   const struct rmap_render_plan *plan,
                                   struct rmap_render_pass *pass, struct rmap_film *film,
                                   struct rmap_render_outcome *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double end = plan->time_limit_s > 0.0 ? rmap_clock_seconds() + plan->time_limit_s : 0.0;
    uint64_t done = 0;
    struct tidings tidings = {0};
    while (done < plan->n_sample && !tidings.late && !tidings.interrupt) {
        double begun = rmap_clock_seconds();
        rmap_film_clear(pass->film);
        pass->first = done;
        pass->n = pass_samples(done, plan->n_sample);
        pass->deadline = done > 0 ? end : 0.0;
        RMAP_TRY(rmap_render_pass_run(pass, err));
        tidings.late = end > 0.0 && rmap_clock_seconds() > end;
        RMAP_TRY(tell(context, pass, outcome, &tidings, err));
        if (tidings.dropped)
            RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "stopped"));
        RMAP_TRY(gather(context, pass->film, err));
        if (tidings.n_tile < rmap_film_n_tile(pass->film))
            break; /* half a pass is none */
        rmap_render_counts_add(&outcome->counts, &pass->counts);
        done += pass->n;
        pass->film->n_sample = pass->n;
        if (context->rank == 0)
            rmap_film_add(film, pass->film);
        outcome->seconds += rmap_clock_seconds() - begun;
        if (context->rank == 0)
            st = plan->show(plan->self, film, err);
        RMAP_TRY(rmap_agree(context, st, err));
    }
out:
    return st;
}

enum rmap_status rmap_render_run(const struct rmap_context *context,
                                 const struct rmap_render_plan *plan,
                                 struct rmap_render_outcome *outcome, struct rmap_error *err)
{
    struct rmap_film *film = NULL;
    struct rmap_progress progress = {0};
    struct rmap_render_pass pass = {
        .context = context, .renderer = plan->renderer, .progress = &progress};
    *outcome = (struct rmap_render_outcome){.n_thread = context->n_thread};
    enum rmap_status st = rmap_film_create(plan->renderer->size, &pass.film, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_film_create(plan->renderer->size, &film, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, &outcome->n_thread, 1, MPI_INT, MPI_SUM, context->comm)));
    rmap_progress_init(&progress, context, "tile samples",
                       plan->time_limit_s > 0.0 ? 0 : rmap_film_n_tile(pass.film) * plan->n_sample);
    RMAP_TRY(run_passes(context, plan, &pass, film, outcome, err));
    if (context->rank == 0 && film->n_sample > 0) {
        outcome->film = film;
        film = NULL;
    }
out:
    rmap_progress_fini(&progress);
    rmap_film_destroy(pass.film);
    rmap_film_destroy(film);
    return st;
}
