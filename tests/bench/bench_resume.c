/* SPDX-License-Identifier: MIT
 *
 * Measurement of going on with a large map: a block more, everything included, against tracing
 * the map anew.
 */
#include "bench.h"
#include "mpi/command/load.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/trace_session.h"
#include "portion/portion.h"

static enum rmap_status run_session(const struct rmap_bench *bench, const char *scene_path,
                                    const struct rmap_trace_request *request, double *seconds_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_trace_session session = {
        .context = &bench->alone, .request = *request, .begun = rmap_clock_seconds()};
    double begun = session.begun;
    RMAP_TRY(rmap_load_scene(&bench->alone, scene_path, &session.request.scene, &session.bundle,
                             &session.scene, err));
    RMAP_TRY(rmap_trace_session_begin(&session, err));
    RMAP_TRY(rmap_trace_session_run(&session, err));
    RMAP_TRY(rmap_trace_session_conclude(&session, err));
    *seconds_ret = rmap_clock_seconds() - begun;
out:
    rmap_trace_session_fini(&session);
    return st;
}

/* The map grows by a block each time, which changes nothing of its size. */
enum rmap_status rmap_bench_resume(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   const char *scene_path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    double anew_s, more_s;
    char path[600];
    const uint64_t n_ray = bench->quick ? 500000 : 10000000;
    (void)snprintf(path, sizeof path, "%s/resume-%s.raymap", bench->folder, scene->name);
    struct rmap_trace_request request = {.scene_path = scene_path,
                                         .map_path = path,
                                         .n_ray = n_ray,
                                         .has_n_ray = true,
                                         .seed = 1,
                                         .encoding = RMAP_ENCODING_COMPACT,
                                         .has_encoding = true};
    RMAP_TRY(run_session(bench, scene_path, &request, &anew_s, err));
    request.mode = RMAP_TRACE_APPEND;
    request.n_ray = RMAP_BLOCK_RAYS;
    for (int i = 0; i < bench->n_repeat; i++) {
        RMAP_TRY(run_session(bench, scene_path, &request, &more_s, err));
        rmap_bench_add(&series, more_s, anew_s);
    }
    rmap_bench_report(bench, "resume_vs_anew", scene, &series, "s",
                      json_pack("{s:I}", "rays", (json_int_t)n_ray));
out:
    return st;
}
