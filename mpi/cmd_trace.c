/* SPDX-License-Identifier: MIT
 *
 * raymap trace: a scene's rays, traced on all ranks, every one of them kept in a ray map.
 */
#include <string.h>

#include "mpi/agree.h"
#include "mpi/balance.h"
#include "mpi/interrupt.h"
#include "mpi/progress.h"
#include "mpi/trace_request.h"
#include "mpi/trace_summary.h"

/* Everything that a run holds, so that it is released in one place. */
struct session {
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_accel *accel;
    struct rmap_forward *forward;
    struct rmap_shard_writer *writer;
    struct rmap_run run;
    struct rmap_trace_outcome outcome;
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

/* Collective. */
static enum rmap_status prepare(const struct rmap_context *context,
                                const struct rmap_trace_request *request, struct session *session,
                                struct rmap_error *err)
{
    enum rmap_status st =
        rmap_accel_create(session->scene, context->n_thread, &session->accel, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(check_isa(context, rmap_accel_isa(session->accel), err));
    const struct rmap_shard_options shard = {.piece_nbytes = request->piece_nbytes,
                                             .flush_seconds = RMAP_FLUSH_SECONDS};
    session->run = (struct rmap_run){.bundle = session->bundle,
                                     .scene = session->scene,
                                     .seed = request->seed,
                                     .n_rank = context->size,
                                     .encoding = request->encoding,
                                     .isa = rmap_accel_isa(session->accel),
                                     .embree_version = rmap_accel_embree_version()};
    if (!request->map_path)
        goto out;
    if (context->rank == 0)
        st = rmap_map_create(request->map_path, request->force, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_forward_create(context, request->shards_per_node, &session->forward, err));
    if (rmap_forward_writes(session->forward))
        st = rmap_shard_writer_create(request->map_path, context->rank, &session->run, &shard,
                                      &session->writer, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Collective: the balance, the index, the summary. */
static enum rmap_status conclude(const struct rmap_context *context,
                                 const struct rmap_trace_request *request,
                                 const struct rmap_trace_plan *plan, struct session *session,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_outcome *outcome = &session->outcome;
    if (context->rank == 0)
        st = rmap_balance_check(outcome->tally, err);
    if (st == RMAP_OK && context->rank == 0 && request->map_path)
        st = rmap_index_write(request->map_path, &session->run, outcome->tally,
                              outcome->n_ray == outcome->n_wanted, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_trace_summarise(context,
                                  &(struct rmap_trace_report){.plan = plan,
                                                              .outcome = outcome,
                                                              .map_path = request->map_path},
                                  err);
    if (st == RMAP_OK && outcome->n_ray < outcome->n_wanted)
        st = rmap_error_set(
            err, RMAP_STOPPED, "stopped early by %s: %llu of %llu rays traced%s",
            outcome->interrupt ? rmap_interrupt_name(outcome->interrupt) : "the time limit",
            (unsigned long long)outcome->n_ray, (unsigned long long)outcome->n_wanted,
            request->map_path ? "; the map holds them" : "");
    return rmap_agree(context, st, err);
}

static enum rmap_status run_trace(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_trace_request request;
    struct session session = {0};
    double begun = rmap_clock_seconds();
    enum rmap_status st = rmap_trace_request_read(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, request.scene_path, &request.scene, &session.bundle,
                             &session.scene, err));
    st = rmap_trace_request_complete(given, session.scene, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(prepare(context, &request, &session, err));
    struct rmap_ray_range range = {request.first_ray, request.first_ray + request.n_ray};
    const struct rmap_ray_set rays = {.range = &range, .n = 1};
    struct rmap_trace_plan plan = {
        .scene = session.scene,
        .accel = session.accel,
        .seed = request.seed,
        .rays = &rays,
        .deadline = request.time_limit_s > 0.0 ? begun + request.time_limit_s : 0.0,
        .writer = session.writer,
        .forward = session.forward,
    };
    RMAP_TRY(rmap_trace_run(context, &plan, &session.outcome, err));
    RMAP_TRY(conclude(context, &request, &plan, &session, err));
out:
    rmap_tally_destroy(session.outcome.tally);
    rmap_shard_writer_destroy(session.writer);
    rmap_forward_destroy(session.forward);
    rmap_accel_destroy(session.accel);
    rmap_scene_destroy(session.scene);
    rmap_bundle_destroy(session.bundle);
    return st;
}

const struct rmap_command rmap_command_trace = {
    .name = "trace",
    .summary = "trace a scene's rays and keep their histories in a ray map",
    .operands = "SCENE -o MAP [-n RAYS] [options]",
    .help =
        "Traces the rays of a scene file and records every step of every one of them. A ray is\n"
        "a pure function of the scene, the seed and its number: any number of ranks and\n"
        "threads gives the same map. SIGTERM, SIGINT, SIGUSR1 and --time-limit end it in good\n"
        "order: what was traced is in the map, and the exit status is 6.",
    .options = rmap_trace_options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_trace,
};
