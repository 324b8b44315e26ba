/* SPDX-License-Identifier: MIT
 *
 * Measurements of pictures: how many a second, and how much of the time is neither index
 * evaluation nor the search for surfaces.
 */
#include "base/alloc.h"
#include "bench.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/progress.h"
#include "mpi/trace/render_pass.h"

/* ---- pictures a second ---- */

static enum rmap_status make_renderer(const struct rmap_bench_scene *scene, const uint32_t size[2],
                                      struct rmap_renderer **renderer_ret, struct rmap_error *err)
{
    if (scene->scene->n_camera == 0)
        return rmap_error_set(err, RMAP_INPUT, "scene %s has no camera", scene->name);
    return rmap_renderer_create(scene->scene, scene->accel, &scene->scene->camera[0], size, 1,
                                renderer_ret, err);
}

/* Against what the seed's authors report of such a scene on a laptop's RTX 2060: 30 pictures a
 * second for a spherical gradient, 15 for noise. */
static enum rmap_status measure_preview(struct rmap_bench *bench,
                                        const struct rmap_bench_scene *scene,
                                        struct rmap_error *err)
{
    static const uint32_t size[2] = {640, 480}, small[2] = {160, 120};
    enum rmap_status st = RMAP_OK;
    struct rmap_renderer *renderer = NULL;
    struct rmap_bench_series series = {0};
    struct rmap_progress silent = {0};
    struct rmap_render_pass pass = {.context = &bench->alone, .progress = &silent, .n = 1};
    const uint32_t *used = bench->quick ? small : size;
    double factor = bench->quick ? 1.0 / 16.0 : 1.0; /* to pictures of 640 x 480 */
    RMAP_TRY(make_renderer(scene, used, &renderer, err));
    RMAP_TRY(rmap_film_create(used, &pass.film, err));
    pass.renderer = renderer;
    pass.end_tile = rmap_film_n_tile(pass.film);
    for (int i = 0; i < bench->n_repeat; i++) {
        double begun = rmap_clock_seconds();
        pass.first = (uint64_t)i;
        RMAP_TRY(rmap_render_pass_run(&pass, err));
        rmap_bench_add(&series, factor / (rmap_clock_seconds() - begun), scene->set ? 15.0 : 30.0);
    }
    rmap_bench_report(bench, "render_preview", scene, &series, "pictures/s",
                      json_pack("{s:i, s:s}", "threads", bench->alone.n_thread, "reference_of",
                                "the seed's report, RTX 2060"));
out:
    rmap_film_destroy(pass.film);
    rmap_renderer_destroy(renderer);
    return st;
}

/* ---- what is neither index evaluation nor search for surfaces ---- */

struct evaluation {
    struct rmap_vec3 point, direction;
    int channel;
    bool best_step; /* asked for, from there in the direction, both of the field's frame */
};

/* What a run asked of one field, and of the accelerator. Points are of the world. */
struct watched_field {
    struct rmap_field base;
    struct rmap_field_ops ops;
    const struct rmap_field *real;
    const struct rmap_gradient *place;
    struct evaluation *evaluation;
    size_t n, cap;
    bool failed;
};

struct watched {
    struct watched_field *field; /* [n_gradient] */
    struct rmap_replay_ray *query;
    size_t n_field, n, cap;
    bool failed;
};

/* The one measurement where a field changes when it is asked. */
static void keep(const struct rmap_field *field, const struct evaluation *evaluation)
{
    struct watched_field *self = (struct watched_field *)(uintptr_t)field;
    if (RMAP_RESERVE(self->evaluation, self->cap, self->n + 1, NULL) == RMAP_OK) {
        self->evaluation[self->n++] = *evaluation;
    } else {
        self->failed = true;
    }
}

static bool watch_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                     struct rmap_vec3 *gradient)
{
    const struct watched_field *self = (const struct watched_field *)field;
    struct rmap_vec3 point = rmap_affine_point(&self->place->to_world, p);
    keep(field, &(struct evaluation){.point = point, .channel = channel});
    return self->real->ops->at(self->real, channel, p, n, gradient);
}

static double watch_best_step(const struct rmap_field *field, struct rmap_vec3 p,
                              struct rmap_vec3 direction)
{
    const struct rmap_field *real = ((const struct watched_field *)field)->real;
    keep(field, &(struct evaluation){.point = p, .direction = direction, .best_step = true});
    return real->ops->best_step(real, p, direction);
}

static bool pass_quadratic(const struct rmap_field *field, int channel, double bend[3][3])
{
    return rmap_field_quadratic(((const struct watched_field *)field)->real, channel, bend);
}

static void watch_query(void *context, const struct rmap_ray *ray, double length)
{
    struct watched *self = context;
    if (RMAP_RESERVE(self->query, self->cap, self->n + 1, NULL) != RMAP_OK) {
        self->failed = true;
        return;
    }
    self->query[self->n++] = (struct rmap_replay_ray){.ray = *ray, .length = length};
}

static double render(const struct rmap_renderer *renderer)
{
    struct rmap_render_counts counts = {0};
    double rgb[5], sum = 0.0;
    for (uint32_t y = 0; y < renderer->size[1]; y++)
        for (uint32_t x = 0; x < renderer->size[0]; x++) {
            rmap_render_sample(renderer, x, y, 0, &counts, rgb);
            sum += rgb[0];
        }
    return sum;
}

/* Renders once with everything written down. */
static enum rmap_status watch(const struct rmap_bench_scene *scene,
                              const struct rmap_renderer *renderer, struct watched *watched,
                              struct rmap_error *err)
{
    watched->n_field = scene->scene->n_gradient;
    watched->field = rmap_alloc(watched->n_field, sizeof *watched->field);
    if (!watched->field)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (size_t g = 0; g < watched->n_field; g++) {
        struct watched_field *field = &watched->field[g];
        field->real = scene->scene->gradient[g].field;
        field->place = &scene->scene->gradient[g];
        field->base = *field->real;
        field->ops = *field->real->ops;
        field->ops.at = watch_at;
        field->ops.best_step = field->real->ops->best_step ? watch_best_step : NULL;
        field->ops.quadratic = pass_quadratic;
        field->base.ops = &field->ops;
        scene->scene->gradient[g].field = &field->base;
    }
    rmap_accel_watch(scene->accel, watch_query, watched);
    (void)render(renderer);
    rmap_accel_watch(scene->accel, NULL, NULL);
    for (size_t g = 0; g < watched->n_field; g++) {
        scene->scene->gradient[g].field = watched->field[g].real;
        watched->failed = watched->failed || watched->field[g].failed;
    }
    if (watched->failed)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for what is to be replayed");
    return rmap_accel_prepare(scene->accel, watched->query, watched->n, err);
}

/* Each evaluation waits for the one before it, as the stages of a step do: `nothing` is 0. */
static double evaluate_again(const struct watched *watched, double nothing)
{
    double sum = 0.0, n = 0.0;
    struct rmap_vec3 slope = {0, 0, 0};
    for (size_t g = 0; g < watched->n_field; g++) {
        const struct watched_field *field = &watched->field[g];
        for (size_t i = 0; i < field->n; i++) {
            const struct evaluation *asked = &field->evaluation[i];
            struct rmap_vec3 point = rmap_axpy(nothing, slope, asked->point);
            if (asked->best_step)
                n = field->real->ops->best_step(field->real, point, asked->direction);
            else
                (void)rmap_gradient_at(field->place, asked->channel, point, &n, &slope);
            sum += n + slope.x;
        }
    }
    return isfinite(sum) ? sum : 0.0;
}

/* The queries as the picture puts them: by prefilter and Embree, with positions and normals. */
static size_t search_again(const struct rmap_accel *accel, const struct watched *watched)
{
    size_t n_hit = 0;
    for (size_t i = 0; i < watched->n; i++) {
        struct rmap_hit hit;
        n_hit +=
            rmap_accel_next_within(accel, &watched->query[i].ray, watched->query[i].length, &hit);
    }
    return n_hit;
}

static void watched_fini(struct watched *watched)
{
    for (size_t g = 0; watched->field && g < watched->n_field; g++)
        rmap_free(watched->field[g].evaluation);
    rmap_free(watched->field);
    rmap_free(watched->query);
}

/* Processor time of the picture, and of its parts alone. */
struct spent {
    double all, evaluating;
    double searching; /* whole queries */
    double embree;    /* the same to rtcIntersect1 alone, prepared, the hits not finished */
};

static json_t *shares(const struct spent *spent, const struct watched *watched, double paths)
{
    size_t n_evaluation = 0;
    for (size_t g = 0; g < watched->n_field; g++)
        n_evaluation += watched->field[g].n;
    double rest = spent->all - spent->evaluating;
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "share_outside_surface_queries",
                     (rest - spent->searching) / spent->all, "share_outside_embree_alone",
                     (rest - spent->embree) / spent->all, "share_evaluating",
                     spent->evaluating / spent->all, "share_surface_queries",
                     spent->searching / spent->all, "share_embree_alone",
                     spent->embree / spent->all, "evaluations_per_path",
                     (double)n_evaluation / paths, "queries_per_path", (double)watched->n / paths);
}

/* One thread; the same picture, then its index evaluations and its queries alone. */
static enum rmap_status measure_overhead(struct rmap_bench *bench,
                                         const struct rmap_bench_scene *scene,
                                         struct rmap_error *err)
{
    static const uint32_t size[2] = {160, 120}, small[2] = {80, 60};
    enum rmap_status st = RMAP_OK;
    struct rmap_renderer *renderer = NULL;
    struct watched watched = {0};
    struct rmap_bench_series series = {0};
    struct spent spent = {0};
    volatile double nothing = 0.0;
    double sum = 0.0;
    RMAP_TRY(make_renderer(scene, bench->quick ? small : size, &renderer, err));
    RMAP_TRY(watch(scene, renderer, &watched, err));
    double paths = (double)renderer->size[0] * renderer->size[1];
    for (int i = 0; i < bench->n_repeat; i++) {
        double start = rmap_bench_cpu();
        sum += render(renderer);
        double rendered = rmap_bench_cpu();
        sum += evaluate_again(&watched, nothing);
        double evaluated = rmap_bench_cpu();
        sum += (double)search_again(scene->accel, &watched);
        double searched = rmap_bench_cpu();
        sum += (double)rmap_accel_replay(scene->accel, watched.query, watched.n);
        double asked = rmap_bench_cpu();
        spent.all += rendered - start;
        spent.evaluating += evaluated - rendered;
        spent.searching += searched - evaluated;
        spent.embree += asked - searched;
        rmap_bench_add(&series, paths / (rendered - start), paths / (searched - rendered));
    }
    if (!(sum > 0.0))
        RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the picture is dark"));
    rmap_bench_report(bench, "render_overhead", scene, &series, "paths/s of processor time",
                      shares(&spent, &watched, paths));
out:
    watched_fini(&watched);
    rmap_renderer_destroy(renderer);
    return st;
}

enum rmap_status rmap_bench_render(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (rmap_bench_wanted(bench, "render_preview"))
        RMAP_TRY(measure_preview(bench, scene, err));
    if (rmap_bench_wanted(bench, "render_overhead"))
        RMAP_TRY(measure_overhead(bench, scene, err));
out:
    return st;
}
