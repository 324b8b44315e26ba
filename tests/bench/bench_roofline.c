/* SPDX-License-Identifier: MIT
 *
 * Measurements against Embree alone: tracing, and drawing directions of scatter models.
 */
#include <math.h>

#include "base/alloc.h"
#include "bench.h"
#include "mpi/parallel/progress.h"
#include "scatter/dust.h"
#include "scatter/scatter.h"
#include "scatter/table.h"
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

/* The queries of n_ray rays, ready to be replayed; rmap_free. */
static enum rmap_status keep_segments(const struct rmap_bench_scene *scene, uint64_t n_ray,
                                      struct rmap_replay_ray **segment_ret, size_t *n_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct segment_recorder recorder = {.base = {.emit = keep_emit,
                                                 .step = keep_step,
                                                 .registration = keep_registration,
                                                 .end = keep_end}};
    struct rmap_tracer tracer = {.scene = scene->scene, .accel = scene->accel, .seed = 1};
    for (uint64_t ray = 0; ray < n_ray; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    if (recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the segments to replay"));
    RMAP_TRY(rmap_accel_prepare(scene->accel, recorder.segment, recorder.n, err));
    *segment_ret = recorder.segment;
    *n_ret = recorder.n;
    recorder.segment = NULL;
out:
    rmap_free(recorder.segment);
    return st;
}

enum rmap_status rmap_bench_roofline(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n_ray = bench->quick ? 10000 : 50000;
    struct rmap_tally *tally = NULL;
    struct rmap_tally_recorder silent;
    struct rmap_bench_series series = {0};
    struct rmap_replay_ray *segment = NULL;
    size_t n_segment = 0;
    struct rmap_tracer tracer = {.scene = scene->scene, .accel = scene->accel, .seed = 1};
    RMAP_TRY(rmap_tally_create(scene->scene, &tally, err));
    rmap_tally_recorder_init(&silent, tally, NULL);
    RMAP_TRY(keep_segments(scene, n_ray, &segment, &n_segment, err));
    for (int i = 0; i < bench->n_repeat; i++) {
        double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
        for (uint64_t ray = 0; ray < n_ray; ray++)
            rmap_trace_ray(&tracer, ray, &silent.base);
        double traced = rmap_clock_seconds(), traced_cpu = rmap_bench_cpu() - cpu;
        size_t n_hit = rmap_accel_replay(scene->accel, segment, n_segment);
        double replayed = rmap_clock_seconds();
        if (n_hit == 0)
            RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the replayed segments hit nothing"));
        rmap_bench_add_cpu(&series, traced_cpu, rmap_bench_cpu() - cpu - traced_cpu);
        double n = 1e-6 * (double)n_segment;
        rmap_bench_add(&series, n / (traced - begun), n / (replayed - traced));
    }
    rmap_bench_report(bench, "trace_vs_roofline", scene, &series, "million segments/s per core",
                      NULL);
out:
    rmap_free(segment);
    rmap_tally_destroy(tally);
    return st;
}

/* A model on one channel, with the parameters that the documents show. */
struct model {
    enum rmap_scatter_model model;
    double shape[RMAP_SHAPE_MAX];
};
static const struct model model[] = {
    {RMAP_SCATTER_LAMBERT, {0}},
    {RMAP_SCATTER_GAUSSIAN, {0.05}},
    {RMAP_SCATTER_COSINE, {30}},
    {RMAP_SCATTER_ABG, {1e-3, 1.8}},
    {RMAP_SCATTER_HARVEY, {0.01, -1.5}},
    {RMAP_SCATTER_K_CORRELATION, {0.02, 2.4}},
    {RMAP_SCATTER_GGX, {0.3, 0.3}},
    {RMAP_SCATTER_BECKMANN, {0.3, 0.3}},
    {RMAP_SCATTER_UNIFIED, {0.1, 0, 1, 0}},
    {RMAP_SCATTER_RETRO, {0.01}},
    {RMAP_SCATTER_TABLE, {0}},
    {RMAP_SCATTER_CONTAMINATION, {0}},
    {RMAP_SCATTER_OREN_NAYAR, {0.5, 1.82}},
};

/* Every 5 degrees, from 7 angles of incidence. */
static enum rmap_status make_table(struct rmap_scatter *scatter, struct rmap_error *err)
{
    enum { RINGS = 18, TURNS = 72, INCIDENCES = 7 };
    enum rmap_status st = RMAP_OK;
    double edge[RINGS + 1], theta[INCIDENCES], worst;
    for (int i = 0; i <= RINGS; i++)
        edge[i] = 5.0 * i;
    for (int i = 0; i < INCIDENCES; i++)
        theta[i] = 14.0 * i;
    RMAP_TRY(rmap_scatter_table_create(&(struct rmap_scatter_table_shape){.n_ring = RINGS,
                                                                          .ring_deg = edge,
                                                                          .n_phi_each = TURNS,
                                                                          .n_theta = INCIDENCES,
                                                                          .theta_deg = theta,
                                                                          .n_turn = 1,
                                                                          .n_band = 1,
                                                                          .side = {true, true}},
                                       &scatter->table, err));
    for (size_t i = 0; i < scatter->table->n_in * scatter->table->out.n; i++)
        scatter->table->block[0].value[i] = scatter->table->block[1].value[i] =
            0.1 + 0.01 * (double)(i % 11);
    (void)rmap_scatter_table_finish(scatter->table, false, &worst);
out:
    return st;
}

static enum rmap_status make_model(const struct model *its, struct rmap_scatter *scatter,
                                   struct rmap_error *err)
{
    static const double one = 1.0;
    static const struct rmap_channels channels = {.n = 1, .wavelength_nm = {550.0}};
    static const struct rmap_dust_kind dust = {400, 0.926, 0.09290304e12, {1.53}, {1e-3}};
    *scatter = (struct rmap_scatter){.model = its->model, .amount = {1.0}};
    for (int i = 0; i < RMAP_SHAPE_MAX; i++)
        scatter->shape[i][0] = its->shape[i];
    rmap_scatter_derive(scatter, 1);
    if (its->model == RMAP_SCATTER_TABLE)
        return make_table(scatter, err);
    if (its->model == RMAP_SCATTER_CONTAMINATION)
        return rmap_scatter_set_dust(scatter, &dust, &channels, NULL, 0, err);
    return rmap_scatter_tabulate(scatter, 1, -1, -1, &one, &one, err);
}

/* A direction of each of n rays, and the BSDF towards it. */
static double draw_directions(const struct rmap_scatter *scatter, size_t n)
{
    double sum = 0.0, cosine;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_draw draw = {.seed = 1, .ray = i, .step = 1};
        const double z = ((double)(i % 64) + 0.5) / 64.0;
        const struct rmap_scattering at = {.scatter = scatter,
                                           .n1 = 1.0,
                                           .n2 = 1.0,
                                           .in = {sqrt(1.0 - z * z), 0.0, -z},
                                           .total = 1.0,
                                           .ahead = 1.0,
                                           .back = 1.0};
        if (rmap_scatter_is_facets(scatter)) {
            const struct rmap_vec3 out = rmap_facet_reflected(at.in, rmap_facet_draw(&at, &draw));
            sum += out.z > 0.0 ? rmap_facet_bsdf(&at, out, &cosine) : 0.0;
        } else {
            sum += rmap_lobe_shape(&at, rmap_lobe_draw(&at, &draw)) / rmap_scatter_total(&at, 0, 0);
        }
    }
    return sum;
}

enum rmap_status rmap_bench_scatter(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t n_ray = bench->quick ? 10000 : 50000;
    struct rmap_replay_ray *segment = NULL;
    struct rmap_scatter scatter = {.model = RMAP_SCATTER_LAMBERT};
    size_t n_segment = 0;
    RMAP_TRY(keep_segments(scene, n_ray, &segment, &n_segment, err));
    for (size_t k = 0; k < sizeof model / sizeof *model; k++) {
        struct rmap_bench_series series = {0};
        RMAP_TRY(make_model(&model[k], &scatter, err));
        for (int i = 0; i < bench->n_repeat; i++) {
            const double begun = rmap_clock_seconds(), cpu = rmap_bench_cpu();
            const double sum = draw_directions(&scatter, n_segment);
            const double drawn = rmap_clock_seconds(), drawn_cpu = rmap_bench_cpu() - cpu;
            const size_t n_hit = rmap_accel_replay(scene->accel, segment, n_segment);
            const double replayed = rmap_clock_seconds(), n = 1e-6 * (double)n_segment;
            if (n_hit == 0 || !(sum > 0.0))
                RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "nothing was hit or drawn"));
            rmap_bench_add_cpu(&series, drawn_cpu, rmap_bench_cpu() - cpu - drawn_cpu);
            rmap_bench_add(&series, n / (drawn - begun), n / (replayed - drawn));
        }
        rmap_bench_report(bench, "scatter_vs_roofline", scene, &series,
                          "million directions/s per core",
                          json_pack("{s:s}", "model", rmap_scatter_name[model[k].model].name));
        rmap_scatter_fini(&scatter);
    }
out:
    rmap_scatter_fini(&scatter);
    rmap_free(segment);
    return st;
}
