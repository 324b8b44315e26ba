/* SPDX-License-Identifier: MIT
 *
 * Measurement of tracing against Embree alone.
 */
#include "base/alloc.h"
#include "bench.h"
#include "mpi/parallel/progress.h"
#include "trace/tracer.h"

/* Keeps the query of every segment, as the tracer asked it. */
struct segment_recorder {
    struct rmap_recorder base;
    struct rmap_ray ray;
    struct rmap_replay_ray *segment;
    size_t n, cap;
    enum rmap_status status;
};

static void keep_emit(struct rmap_recorder *base, const struct rmap_emission *emission)
{
    struct segment_recorder *self = (struct segment_recorder *)base;
    self->ray = (struct rmap_ray){
        .origin = emission->position, .direction = emission->direction, .medium = emission->medium};
}

/* The contact is brought forward as the tracer does, so that the replayed queries are the same. */
static void keep_step(struct rmap_recorder *base, const struct rmap_step *step)
{
    const uint32_t turned =
        RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TOTAL_REFLECTION;
    struct segment_recorder *self = (struct segment_recorder *)base;
    if (RMAP_RESERVE(self->segment, self->cap, self->n + 1, NULL) != RMAP_OK) {
        self->status = RMAP_SYSTEM;
        return;
    }
    self->ray.direction = step->direction;
    self->ray.medium = step->medium;
    self->segment[self->n++] = (struct rmap_replay_ray){.ray = self->ray};
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
    struct segment_recorder recorder = {.base = {.emit = keep_emit,
                                                 .step = keep_step,
                                                 .registration = keep_registration,
                                                 .end = keep_end}};
    struct rmap_tracer tracer = {.scene = scene->scene, .accel = scene->accel, .seed = 1};
    RMAP_TRY(rmap_tally_create(scene->scene, &tally, err));
    rmap_tally_recorder_init(&silent, tally, NULL);
    for (uint64_t ray = 0; ray < n_ray; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    if (recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the segments to replay"));
    RMAP_TRY(rmap_accel_prepare(scene->accel, recorder.segment, recorder.n, err));
    for (int i = 0; i < bench->n_repeat; i++) {
        double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
        for (uint64_t ray = 0; ray < n_ray; ray++)
            rmap_trace_ray(&tracer, ray, &silent.base);
        double traced = rmap_clock_seconds(), traced_cpu = rmap_bench_cpu() - cpu;
        size_t n_hit = rmap_accel_replay(scene->accel, recorder.segment, recorder.n);
        double replayed = rmap_clock_seconds();
        if (n_hit == 0)
            RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the replayed segments hit nothing"));
        rmap_bench_add_cpu(&series, traced_cpu, rmap_bench_cpu() - cpu - traced_cpu);
        double n = 1e-6 * (double)recorder.n;
        rmap_bench_add(&series, n / (traced - begun), n / (replayed - traced));
    }
    rmap_bench_report(bench, "trace_vs_roofline", scene, &series, "million segments/s per core",
                      NULL);
out:
    rmap_free(recorder.segment);
    rmap_tally_destroy(tally);
    return st;
}
