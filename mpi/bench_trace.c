/* SPDX-License-Identifier: MIT
 *
 * Measurements of tracing and recording.
 */
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/map_reader.h"
#include "mpi/agree.h"
#include "mpi/bench.h"
#include "mpi/bench_seed.h"
#include "mpi/progress.h"
#include "mpi/trace_run.h"
#include "trace/tracer.h"

/* Keeps the query of every leg, as the tracer asked it. */
struct leg_recorder {
    struct rmap_recorder base;
    struct rmap_ray ray;
    struct rmap_replay_ray *leg;
    size_t n, cap;
    enum rmap_status status;
};

static void keep_emit(struct rmap_recorder *base, const struct rmap_emission *emission)
{
    struct leg_recorder *self = (struct leg_recorder *)base;
    self->ray = (struct rmap_ray){
        .origin = emission->position, .direction = emission->direction, .medium = emission->medium};
}

/* The contact is brought forward as the tracer does, so that the replayed queries are the same. */
static void keep_step(struct rmap_recorder *base, const struct rmap_step *step)
{
    const uint32_t turned =
        RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TOTAL_REFLECTION;
    struct leg_recorder *self = (struct leg_recorder *)base;
    void *leg = self->leg;
    if (rmap_reserve(&leg, &self->cap, self->n + 1, sizeof *self->leg, NULL) != RMAP_OK) {
        self->status = RMAP_SYSTEM;
        return;
    }
    self->leg = leg;
    self->ray.direction = step->direction;
    self->ray.medium = step->medium;
    self->leg[self->n++] = (struct rmap_replay_ray){.ray = self->ray};
    struct rmap_hit hit = {.t = step->length,
                           .position = step->position,
                           .normal = step->normal,
                           .object = step->object,
                           .primitive = step->primitive};
    if (step->object >= 0 && (step->events & turned))
        rmap_contact_turn(&self->ray.contact, &hit);
    else if (step->object >= 0)
        rmap_contact_pass(&self->ray.contact, &hit);
    self->ray.origin = step->position;
}

static void keep_registration(struct rmap_recorder *base,
                              const struct rmap_registration *registration)
{
    (void)base;
    (void)registration;
}

static void keep_end(struct rmap_recorder *base, const struct rmap_ending *ending)
{
    (void)base;
    (void)ending;
}

enum rmap_status rmap_bench_roofline(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n_ray = bench->quick ? 10000 : 50000;
    struct rmap_tally *tally = NULL;
    struct rmap_tally_recorder silent;
    struct rmap_bench_series series = {0};
    struct leg_recorder recorder = {.base = {keep_emit, keep_step, keep_registration, keep_end}};
    struct rmap_tracer tracer = {.scene = scene->scene, .accel = scene->accel, .seed = 1};
    RMAP_TRY(rmap_tally_create(scene->scene, &tally, err));
    rmap_tally_recorder_init(&silent, tally, NULL);
    for (uint64_t ray = 0; ray < n_ray; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    if (recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the legs to replay"));
    rmap_accel_prepare(scene->accel, recorder.leg, recorder.n);
    for (int i = 0; i < bench->n_repeat; i++) {
        double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
        for (uint64_t ray = 0; ray < n_ray; ray++)
            rmap_trace_ray(&tracer, ray, &silent.base);
        double traced = rmap_clock_seconds(), traced_cpu = rmap_bench_cpu() - cpu;
        size_t n_hit = rmap_accel_replay(scene->accel, recorder.leg, recorder.n);
        double replayed = rmap_clock_seconds();
        if (n_hit == 0)
            RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the replayed legs hit nothing"));
        rmap_bench_add_cpu(&series, traced_cpu, rmap_bench_cpu() - cpu - traced_cpu);
        double n = 1e-6 * (double)recorder.n;
        rmap_bench_add(&series, n / (traced - begun), n / (replayed - traced));
    }
    rmap_bench_report(bench, "trace_vs_roofline", scene, &series, "million segments/s per core",
                      NULL);
out:
    rmap_free(recorder.leg);
    rmap_tally_destroy(tally);
    return st;
}

static enum rmap_status start_map(const struct rmap_context *context, const struct rmap_run *run,
                                  const char *map_path, struct rmap_shard_writer **writer,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (context->rank == 0)
        st = rmap_map_create(map_path, true, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_shard_writer_create(map_path, context->rank, run, 0, writer, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

enum rmap_status rmap_bench_trace(const struct rmap_context *context, int n_thread,
                                  const struct rmap_bench_scene *scene, uint64_t n_ray,
                                  const char *map_path, double *seconds_ret, double *n_segment_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_context here = *context;
    struct rmap_trace_outcome outcome = {0};
    struct rmap_shard_writer *writer = NULL;
    struct rmap_run run = {.bundle = scene->bundle,
                           .scene = scene->scene,
                           .seed = 1,
                           .n_rank = context->size,
                           .isa = rmap_accel_isa(scene->accel),
                           .embree_version = rmap_accel_embree_version()};
    here.n_thread = n_thread;
    if (map_path)
        RMAP_TRY(start_map(&here, &run, map_path, &writer, err));
    struct rmap_ray_range all = {0, n_ray};
    const struct rmap_ray_set rays = {.range = &all, .n = 1};
    struct rmap_trace_plan plan = {
        .scene = scene->scene, .accel = scene->accel, .seed = 1, .rays = &rays, .writer = writer};
    RMAP_TRY(rmap_trace_run(&here, &plan, &outcome, err));
    if (outcome.n_ray < n_ray)
        st = rmap_error_set(err, RMAP_STOPPED, "stopped early");
    RMAP_TRY(st);
    if (map_path && here.rank == 0)
        st = rmap_index_write(map_path, &run, outcome.tally, true, err);
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

/* One round: trace alone, trace into a map, trace into the reference's file. */
static enum rmap_status record_once(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    uint64_t n_ray, struct record_series *series,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char map_path[600], seed_path[600];
    double bare_s, map_s, n_segment, nbytes;
    double cpu[4] = {rmap_bench_cpu()};
    int n_thread = bench->alone.n_thread;
    struct rmap_seed_result seed;
    (void)snprintf(map_path, sizeof map_path, "%s/%s.raymap", bench->folder, scene->name);
    (void)snprintf(seed_path, sizeof seed_path, "%s/%s.seed", bench->folder, scene->name);
    RMAP_TRY(
        rmap_bench_trace(&bench->alone, n_thread, scene, n_ray, NULL, &bare_s, &n_segment, err));
    cpu[1] = rmap_bench_cpu();
    RMAP_TRY(
        rmap_bench_trace(&bench->alone, n_thread, scene, n_ray, map_path, &map_s, &n_segment, err));
    cpu[2] = rmap_bench_cpu();
    RMAP_TRY(rmap_seed_record(scene->scene, scene->accel, n_ray, n_thread, seed_path, &seed, err));
    cpu[3] = rmap_bench_cpu();
    RMAP_TRY(map_nbytes(map_path, &nbytes, err));
    double n = 1e-6 * n_segment;
    rmap_bench_add(&series->trace, n / map_s, n / bare_s);
    rmap_bench_add_cpu(&series->trace, cpu[2] - cpu[1], cpu[1] - cpu[0]);
    rmap_bench_add(&series->seed, n / map_s, n / seed.seconds);
    rmap_bench_add_cpu(&series->seed, cpu[2] - cpu[1], cpu[3] - cpu[2]);
    rmap_bench_add(&series->size, nbytes / n_segment, (double)seed.nbytes / n_segment);
out:
    return st;
}

enum rmap_status rmap_bench_record(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct record_series series = {0};
    uint64_t n_ray = bench->quick ? 100000 : 500000;
    for (int i = 0; i < bench->n_repeat; i++)
        RMAP_TRY(record_once(bench, scene, n_ray, &series, err));
    json_t *plain = json_pack("{s:s}", "encoding", "plain");
    if (rmap_bench_wanted(bench, "record_vs_trace"))
        rmap_bench_report(bench, "record_vs_trace", scene, &series.trace, "million segments/s",
                          json_incref(plain));
    if (rmap_bench_wanted(bench, "record_vs_seed"))
        rmap_bench_report(bench, "record_vs_seed", scene, &series.seed, "million segments/s",
                          json_incref(plain));
    if (rmap_bench_wanted(bench, "bytes_per_segment"))
        rmap_bench_report(bench, "bytes_per_segment", scene, &series.size, "bytes/segment",
                          json_incref(plain));
    json_decref(plain);
out:
    return st;
}
