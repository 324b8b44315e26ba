/* SPDX-License-Identifier: MIT
 *
 * raymap trace: a scene's rays, traced on all ranks, every one of them kept in a ray map.
 */
#include <string.h>

#include "mpi/agree.h"
#include "mpi/balance.h"
#include "mpi/interrupt.h"
#include "mpi/load.h"
#include "mpi/progress.h"
#include "mpi/trace_summary.h"

static const struct rmap_option options[] = {
    {"output", 'o', "MAP", "directory of the ray map to make, by custom NAME.raymap"},
    {"rays", 'n', "RAYS", "how many: 1000000, 1e6, 2M (default: the simulation's, or 1e6)"},
    {"seed", 's', "S", "of the random numbers (default 1): the same seed gives the same rays"},
    {"time-limit", 't', "TIME", "stop in good order after 90s, 15min, 2h: status 6"},
    {"force", 'f', NULL, "replace a ray map that stands there"},
    {"no-record", 0, NULL, "trace and sum up only; makes no map"},
    {"piece-size", 0, "BYTES", "close a file of the map at this size (default 256Mi)"},
    {"resume", 0, NULL, "not in this version"},
    {"append", 0, NULL, "not in this version"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

struct request {
    const char *scene_path, *map_path; /* map_path NULL: nothing is recorded */
    uint64_t n_ray, seed, piece_nbytes;
    double time_limit_s;
    bool force;
    struct rmap_scene_options scene;
};

/* Everything that a run holds, so that it is released in one place. */
struct session {
    struct rmap_bundle *bundle;
    struct rmap_scene *scene;
    struct rmap_accel *accel;
    struct rmap_shard_writer *writer;
    struct rmap_run run;
    struct rmap_trace_outcome outcome;
};

static enum rmap_status check_request(const struct rmap_arguments *given,
                                      const struct request *request, struct rmap_error *err)
{
    static const char *const later[] = {"resume", "append"};
    for (size_t i = 0; i < sizeof later / sizeof later[0]; i++)
        if (rmap_argument(given, later[i]))
            return rmap_error_set(err, RMAP_USAGE,
                                  "--%s is not available in this version; trace into a new map",
                                  later[i]);
    if (rmap_argument(given, "rays") && request->n_ray == 0)
        return rmap_error_set(err, RMAP_USAGE, "-n 0 traces nothing; ask for at least one ray");
    if (rmap_argument(given, "no-record") && request->map_path)
        return rmap_error_set(err, RMAP_USAGE, "--no-record makes no map; leave out -o");
    return RMAP_OK;
}

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct request){.scene_path = given->operand[0], .seed = 1};
    request->map_path = rmap_argument(given, "output");
    request->force = rmap_argument(given, "force") != NULL;
    RMAP_TRY(rmap_argument_count(given, "rays", &request->n_ray, err));
    RMAP_TRY(rmap_argument_count(given, "seed", &request->seed, err));
    RMAP_TRY(rmap_argument_count(given, "piece-size", &request->piece_nbytes, err));
    RMAP_TRY(rmap_argument_seconds(given, "time-limit", &request->time_limit_s, err));
    RMAP_TRY(check_request(given, request, err));
    RMAP_TRY(rmap_scene_options_read(given, &request->scene, err));
out:
    return st;
}

/* What the command line leaves open, the chosen simulation of the scene says. */
static enum rmap_status complete_request(const struct rmap_arguments *given,
                                         const struct rmap_scene *scene, struct request *request,
                                         struct rmap_error *err)
{
    const uint64_t default_rays = 1000000;
    const struct rmap_simulation *simulation = &scene->simulation;
    bool record = !rmap_argument(given, "no-record") && (simulation->record || !simulation->name);
    if (request->n_ray == 0)
        request->n_ray = simulation->rays ? simulation->rays : default_rays;
    if (request->time_limit_s <= 0.0)
        request->time_limit_s = simulation->time_limit_s;
    if (scene->n_source == 0)
        return rmap_error_set(err, RMAP_INPUT, "%s: no source takes part, so there is no light",
                              request->scene_path);
    if (record && !request->map_path)
        return rmap_error_set(err, RMAP_USAGE,
                              "where to? give -o MAP, or --no-record to trace without a map");
    if (!record)
        request->map_path = NULL;
    return RMAP_OK;
}

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
static enum rmap_status prepare(const struct rmap_context *context, const struct request *request,
                                struct session *session, struct rmap_error *err)
{
    enum rmap_status st =
        rmap_accel_create(session->scene, context->n_thread, &session->accel, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(check_isa(context, rmap_accel_isa(session->accel), err));
    session->run = (struct rmap_run){.bundle = session->bundle,
                                     .scene = session->scene,
                                     .seed = request->seed,
                                     .n_rank = context->size,
                                     .isa = rmap_accel_isa(session->accel),
                                     .embree_version = rmap_accel_embree_version()};
    if (!request->map_path)
        goto out;
    if (context->rank == 0)
        st = rmap_map_create(request->map_path, request->force, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_shard_writer_create(request->map_path, context->rank, &session->run,
                                  request->piece_nbytes, &session->writer, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Collective: the balance, the index, the summary. */
static enum rmap_status conclude(const struct rmap_context *context, const struct request *request,
                                 const struct rmap_trace_plan *plan, struct session *session,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_trace_outcome *outcome = &session->outcome;
    if (context->rank == 0)
        st = rmap_balance_check(outcome->tally, err);
    if (st == RMAP_OK && context->rank == 0 && request->map_path)
        st = rmap_index_write(request->map_path, &session->run, outcome->tally,
                              outcome->n_ray == plan->n_ray, err);
    if (st == RMAP_OK && context->rank == 0)
        st = rmap_trace_summarise(context, plan, outcome, request->map_path, err);
    if (st == RMAP_OK && outcome->n_ray < plan->n_ray)
        st = rmap_error_set(err, RMAP_STOPPED, "stopped early by %s: %llu of %llu rays traced%s",
                            outcome->interrupt ? rmap_interrupt_name(outcome->interrupt)
                                               : "the time limit",
                            (unsigned long long)outcome->n_ray, (unsigned long long)plan->n_ray,
                            request->map_path ? "; the map holds them" : "");
    return rmap_agree(context, st, err);
}

static enum rmap_status run_trace(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct session session = {0};
    double begun = rmap_clock_seconds();
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, request.scene_path, &request.scene, &session.bundle,
                             &session.scene, err));
    st = complete_request(given, session.scene, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(prepare(context, &request, &session, err));
    struct rmap_trace_plan plan = {
        .scene = session.scene,
        .accel = session.accel,
        .seed = request.seed,
        .n_ray = request.n_ray,
        .deadline = request.time_limit_s > 0.0 ? begun + request.time_limit_s : 0.0,
        .writer = session.writer,
    };
    RMAP_TRY(rmap_trace_run(context, &plan, &session.outcome, err));
    RMAP_TRY(conclude(context, &request, &plan, &session, err));
out:
    rmap_tally_destroy(session.outcome.tally);
    rmap_shard_writer_destroy(session.writer);
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
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_trace,
};
