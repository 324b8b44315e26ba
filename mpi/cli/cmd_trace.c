/* SPDX-License-Identifier: MIT
 *
 * raymap trace: a scene's rays, traced on all ranks, every one of them kept in a ray map.
 */
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/trace_session.h"

/* -o was given, but the simulation that was picked keeps no rays. */
static void tell_unrecorded(const struct rmap_context *context, const struct rmap_arguments *given,
                            const struct rmap_trace_session *session)
{
    if (context->rank == 0 && !context->quiet && rmap_argument(given, "output") &&
        !session->request.map_path)
        fprintf(stderr, "raymap: simulation '%s' says record: false: no map is made\n",
                session->scene->simulation.name);
}

static enum rmap_status run_trace(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_trace_session session = {.context = context, .begun = rmap_clock_seconds()};
    enum rmap_status st = rmap_trace_request_read(given, &session.request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_load_scene(context, session.request.scene_path, &session.request.scene,
                             &session.bundle, &session.scene, err));
    RMAP_TRY(rmap_trace_from_open(context, &session.request, &session.from, err));
    st = rmap_trace_request_complete(given, session.scene, &session.request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    tell_unrecorded(context, given, &session);
    RMAP_TRY(rmap_trace_session_begin(&session, err));
    RMAP_TRY(rmap_trace_session_run(&session, err));
    RMAP_TRY(rmap_trace_session_conclude(&session, err));
    if (rmap_argument(given, "index") && context->rank == 0 && !context->quiet)
        fprintf(stderr, "raymap: --index: nothing to do: maps need no index\n");
out:
    rmap_trace_session_fini(&session);
    return st;
}

const struct rmap_command rmap_command_trace = {
    .name = "trace",
    .summary = "trace a scene's rays and keep their histories in a ray map",
    .operands = "SCENE -o MAP [-n RAYS] [--resume | --append] [--from MAP] [options]",
    .help =
        "Traces the rays of a scene file and records every step of every one of them. A ray is\n"
        "a pure function of the scene, the seed and its number: any number of ranks and\n"
        "threads gives the same map. SIGTERM, SIGINT, SIGUSR1 and --time-limit end it in good\n"
        "order: what was traced is in the map, and the exit status is 6. It is 7 where more than\n"
        "0.1 % of the map's rays ended in an error: the map is whole, the scene is at fault.\n"
        "After any other end, what was flushed is in the map. --resume traces what is missing,\n"
        "with any number of ranks, and gives the map of an undisturbed run; --append -n MORE adds\n"
        "rays, also in another colour space (--color, --set spectrum...).\n"
        "--from OLD, the map of an earlier version of the scene, keeps the rays that the change\n"
        "leaves as they are and traces the others: the same map in a part of the time.",
    .options = rmap_trace_options,
    .min_operands = 1,
    .max_operands = 1,
    .stops_in_order = true,
    .run = run_trace,
};
