/* SPDX-License-Identifier: MIT
 *
 * A picture, rendered on all ranks in passes over its tiles.
 */
#include "mpi/trace/render_run.h"

#include <math.h>

#include "mpi/parallel/agree.h"
#include "mpi/parallel/interrupt.h"

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

struct tidings {
    bool dropped;  /* nobody wants the picture any longer */
    bool whole;    /* all tiles that were begun are done */
    double busy_s; /* of all threads */
};

/* Collective. Sums and outcomes that every rank needs alike. */
static enum rmap_status tell(struct rmap_render_run *run, struct tidings *tidings,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_render_pass *pass = &run->pass;
    const struct rmap_render_counts *c = &pass->counts;
    MPI_Comm comm = run->context->comm;
    uint64_t sum[7] = {c->n_path,  c->n_segment, c->n_look,    c->n_limit,
                       c->n_error, pass->n_tile, pass->busy_ns};
    int stop[3] = {rmap_interrupt_caught(),
                   run->context->rank == 0 && run->end > 0.0 && rmap_clock_seconds() > run->end,
                   rmap_interrupt_stops_question()};
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, 7, MPI_UINT64_T, MPI_SUM, comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, stop, 3, MPI_INT, MPI_MAX, comm)));
    rmap_render_counts_add(&run->pass_counts,
                           &(struct rmap_render_counts){sum[0], sum[1], sum[2], sum[3], sum[4]});
    tidings->dropped = stop[2] != 0;
    tidings->whole = sum[5] == pass->end_tile - pass->first_tile;
    tidings->busy_s = 1e-9 * (double)sum[6];
    run->interrupt = stop[0];
    const bool has_pass = run->n_done > 0 || pass->end_tile == rmap_film_n_tile(pass->film);
    run->is_over =
        stop[0] != 0 || (stop[1] != 0 && has_pass) || !tidings->whole; /* half a pass is none */
out:
    return st;
}

/* Collective. How many tiles are next; 0: the step is over. Rank 0 says, by its clock: of half of
 * the time that is left, since one tile is not as long as another. The pace is that of free cores:
 * where others have them, few tiles would not be done much sooner than many. */
static enum rmap_status next_tiles(const struct rmap_render_run *run, double until, double seconds,
                                   uint64_t *n_ret, struct rmap_error *err)
{
    const uint64_t left = rmap_film_n_tile(run->pass.film) - run->pass.end_tile;
    *n_ret = left;
    if (!(seconds > 0.0))
        return RMAP_OK;
    const double time = until - rmap_clock_seconds();
    uint64_t n = (uint64_t)(run->pace * fmax(time, 0.0) / 2.0 / (double)run->pass.n);
    if (n < (uint64_t)run->n_thread)
        n = (uint64_t)run->n_thread;
    if (time < seconds / 4.0)
        n = 0;
    *n_ret = n < left ? n : left;
    return RMAP_MPI(MPI_Bcast(n_ret, 1, MPI_UINT64_T, 0, run->context->comm));
}

static void begin_pass(struct rmap_render_run *run)
{
    struct rmap_render_pass *pass = &run->pass;
    rmap_film_clear(pass->film);
    pass->first = run->n_done;
    pass->n = pass_samples(run->n_done, run->plan.n_sample);
    pass->deadline = run->n_done > 0 ? run->end : 0.0;
    pass->first_tile = pass->end_tile = 0;
    run->pass_counts = (struct rmap_render_counts){0};
}

/* Collective. */
static enum rmap_status render_tiles(struct rmap_render_run *run, uint64_t n_tile, bool *whole_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_render_pass *pass = &run->pass;
    struct tidings tidings = {0};
    const double begun = rmap_clock_seconds();
    pass->first_tile = pass->end_tile;
    pass->end_tile += n_tile;
    RMAP_TRY(rmap_render_pass_run(pass, err));
    RMAP_TRY(tell(run, &tidings, err));
    if (tidings.dropped)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "stopped"));
    run->seconds += rmap_clock_seconds() - begun;
    const double pace = (double)(n_tile * pass->n) * run->n_thread / fmax(tidings.busy_s, 1e-6);
    run->pace = run->pace > 0.0 ? fmin(pace, 1.25 * run->pace) : pace; /* slow ones come again */
    *whole_ret = tidings.whole;
out:
    return st;
}

static bool is_power_of_4(uint64_t n)
{
    while (n > 1 && n % 4 == 0)
        n /= 4;
    return n == 1;
}

/* Collective. */
static enum rmap_status end_pass(struct rmap_render_run *run, bool shows, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_render_pass *pass = &run->pass;
    const double begun = rmap_clock_seconds();
    RMAP_TRY(gather(run->context, pass->film, err));
    rmap_render_counts_add(&run->counts, &run->pass_counts);
    run->n_done += pass->n;
    pass->film->n_sample = pass->n;
    if (run->film)
        rmap_film_add(run->film, pass->film);
    run->seconds += rmap_clock_seconds() - begun;
    run->is_over = run->is_over || run->n_done == run->plan.n_sample;
    if (run->film && shows)
        st = run->plan.show(run->plan.self, run->film, err);
    RMAP_TRY(rmap_agree(run->context, st, err));
out:
    return st;
}

enum rmap_status rmap_render_begin(const struct rmap_context *context,
                                   const struct rmap_render_plan *plan, struct rmap_render_run *run,
                                   struct rmap_error *err)
{
    const uint32_t *size = plan->renderer->size;
    *run =
        (struct rmap_render_run){.context = context, .plan = *plan, .n_thread = context->n_thread};
    run->pass = (struct rmap_render_pass){
        .context = context, .renderer = plan->renderer, .progress = &run->progress};
    enum rmap_status st = rmap_film_create(size, &run->pass.film, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_film_create(size, &run->film, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(
        RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, &run->n_thread, 1, MPI_INT, MPI_SUM, context->comm)));
    if (plan->time_limit_s > 0.0)
        run->end = rmap_clock_seconds() + plan->time_limit_s;
    const uint64_t n_tile = rmap_film_n_tile(run->pass.film);
    run->pass.end_tile = n_tile;
    rmap_progress_init(&run->progress, context, "tile samples",
                       run->end > 0.0 ? 0 : n_tile * plan->n_sample);
out:
    return st;
}

enum rmap_status rmap_render_step(struct rmap_render_run *run, double seconds,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t all = rmap_film_n_tile(run->pass.film);
    const double until = rmap_clock_seconds() + seconds;
    for (bool shown = false; !run->is_over && !shown;) {
        uint64_t n_tile = 0;
        bool whole = false;
        if (run->pass.end_tile == all)
            begin_pass(run);
        RMAP_TRY(next_tiles(run, until, seconds, &n_tile, err));
        if (n_tile == 0)
            break;
        RMAP_TRY(render_tiles(run, n_tile, &whole, err));
        if (!whole || run->pass.end_tile < all)
            continue;
        const uint64_t n_done = run->n_done + run->pass.n;
        shown = seconds > 0.0 && (is_power_of_4(n_done) || n_done == run->plan.n_sample);
        RMAP_TRY(end_pass(run, shown || !(seconds > 0.0), err));
    }
out:
    return st;
}

void rmap_render_end(struct rmap_render_run *run)
{
    rmap_progress_fini(&run->progress);
    rmap_film_destroy(run->pass.film);
    rmap_film_destroy(run->film);
}
