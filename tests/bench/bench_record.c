/* SPDX-License-Identifier: MIT
 *
 * Measurements of recording: against tracing alone and against the reference.
 */
#include "bench.h"
#include "bench_seed.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_writer.h"
#include "mpi/parallel/agree.h"
#include "mpi/trace/trace_run.h"

const struct rmap_bench_encoding rmap_bench_encoding[RMAP_BENCH_ENCODINGS] = {
    {RMAP_ENCODING_PLAIN, "plain"},
    {RMAP_ENCODING_COMPACT, "compact"},
};

json_t *rmap_bench_encoding_json(size_t encoding)
{
    return json_pack("{s:s}", "encoding", rmap_bench_encoding[encoding].name);
}

static enum rmap_status start_map(const struct rmap_context *context, const struct rmap_run *run,
                                  const struct rmap_bench_store *store,
                                  struct rmap_shard_writer **writer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shard_options options = {.flush_seconds = RMAP_FLUSH_SECONDS};
    if (store->never_flush || store->flush_portions > 0)
        options.flush_seconds = 0.0;
    if (!store->never_flush)
        options.flush_portions = store->flush_portions;
    if (context->rank == 0)
        st = rmap_map_create(store->path, true, NULL, NULL, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_shard_writer_create(store->path, context->rank, run, &options, writer, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

enum rmap_status rmap_bench_trace(const struct rmap_context *context, int n_thread,
                                  const struct rmap_bench_scene *scene, uint64_t n_ray,
                                  const struct rmap_bench_store *store, double *seconds_ret,
                                  double *n_segment_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_context here = *context;
    struct rmap_trace_outcome outcome = {0};
    struct rmap_shard_writer *writer = NULL;
    struct rmap_run run = {.bundle = scene->bundle,
                           .scene = scene->scene,
                           .seed = 1,
                           .n_rank = context->size,
                           .encoding = store->encoding,
                           .isa = rmap_accel_isa(scene->accel),
                           .embree_version = rmap_accel_embree_version()};
    here.n_thread = n_thread;
    if (store->path)
        RMAP_TRY(start_map(&here, &run, store, &writer, err));
    struct rmap_ray_range all = {0, n_ray};
    const struct rmap_ray_set rays = {.range = &all, .n = 1};
    struct rmap_trace_plan plan = {
        .scene = scene->scene, .accel = scene->accel, .seed = 1, .rays = &rays, .writer = writer};
    RMAP_TRY(rmap_trace_run(&here, &plan, &outcome, err));
    if (writer && store->n_flush)
        *store->n_flush += rmap_shard_writer_flushes(writer);
    if (outcome.n_ray < n_ray)
        st = rmap_error_set(err, RMAP_STOPPED, "stopped early");
    RMAP_TRY(st);
    if (store->path && here.rank == 0)
        st = rmap_index_write(store->path, &run, outcome.tally, true, err);
    RMAP_TRY(rmap_agree(&here, st, err));
    *seconds_ret = outcome.seconds;
    *n_segment_ret = outcome.tally->segments[0];
out:
    rmap_tally_destroy(outcome.tally);
    rmap_shard_writer_destroy(writer);
    return st;
}

static enum rmap_status map_nbytes(const char *path, double *nbytes_ret, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary = {0};
    enum rmap_status st = rmap_map_open(path, &map, err);
    if (st == RMAP_OK)
        rmap_map_summarise(map, &summary);
    *nbytes_ret = (double)summary.nbytes;
    rmap_map_close(map);
    return st;
}

struct record_series {
    struct rmap_bench_series trace, seed, size;
};

static enum rmap_status timed_trace(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    uint64_t n_ray, const struct rmap_bench_store *store,
                                    struct rmap_bench_cost *cost, double *n_segment,
                                    struct rmap_error *err)
{
    double begun = rmap_bench_cpu();
    enum rmap_status st = rmap_bench_trace(&bench->alone, bench->alone.n_thread, scene, n_ray,
                                           store, &cost->wall_s, n_segment, err);
    cost->cpu_s = rmap_bench_cpu() - begun;
    return st;
}

/* One round: trace alone, trace into the reference's file, trace into a map of each encoding. */
static enum rmap_status record_once(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    uint64_t n_ray, struct record_series *series,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char map_path[600], seed_path[600];
    double n_segment, nbytes;
    struct rmap_bench_cost bare, ours, reference;
    struct rmap_seed_result seed;
    (void)snprintf(map_path, sizeof map_path, "%s/%s.raymap", bench->folder, scene->name);
    (void)snprintf(seed_path, sizeof seed_path, "%s/%s.seed", bench->folder, scene->name);
    RMAP_TRY(
        timed_trace(bench, scene, n_ray, &(struct rmap_bench_store){0}, &bare, &n_segment, err));
    double begun = rmap_bench_cpu();
    RMAP_TRY(rmap_seed_record(scene->scene, scene->accel, n_ray, bench->alone.n_thread, seed_path,
                              &seed, err));
    reference = (struct rmap_bench_cost){seed.seconds, rmap_bench_cpu() - begun};
    for (size_t e = 0; e < RMAP_BENCH_ENCODINGS; e++) {
        const struct rmap_bench_store store = {.path = map_path,
                                               .encoding = rmap_bench_encoding[e].encoding};
        RMAP_TRY(timed_trace(bench, scene, n_ray, &store, &ours, &n_segment, err));
        RMAP_TRY(map_nbytes(map_path, &nbytes, err));
        rmap_bench_add_speeds(&series[e].trace, n_segment, ours, bare);
        rmap_bench_add_speeds(&series[e].seed, n_segment, ours, reference);
        rmap_bench_add(&series[e].size, nbytes / n_segment, (double)seed.nbytes / n_segment);
    }
out:
    return st;
}

enum rmap_status rmap_bench_record(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct record_series series[RMAP_BENCH_ENCODINGS] = {0};
    uint64_t n_ray = bench->quick ? 100000 : 500000;
    int n_repeat = scene->sizes_only ? 1 : bench->n_repeat;
    for (int i = 0; i < n_repeat; i++)
        RMAP_TRY(record_once(bench, scene, n_ray, series, err));
    for (size_t e = 0; e < RMAP_BENCH_ENCODINGS; e++) {
        if (rmap_bench_wanted(bench, "record_vs_trace") && !scene->sizes_only)
            rmap_bench_report(bench, "record_vs_trace", scene, &series[e].trace,
                              "million segments/s", rmap_bench_encoding_json(e));
        if (rmap_bench_wanted(bench, "record_vs_seed") && !scene->sizes_only)
            rmap_bench_report(bench, "record_vs_seed", scene, &series[e].seed, "million segments/s",
                              rmap_bench_encoding_json(e));
        if (rmap_bench_wanted(bench, "bytes_per_segment"))
            rmap_bench_report(bench, "bytes_per_segment", scene, &series[e].size, "bytes/segment",
                              rmap_bench_encoding_json(e));
    }
out:
    return st;
}
