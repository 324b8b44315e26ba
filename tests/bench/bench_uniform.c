/* SPDX-License-Identifier: MIT
 *
 * Measurement of what light in uniform media pays for gradient media: the same scene, with the same
 * ball beside it, filled with glass or with a gradient medium that no light comes to.
 */
#include <string.h>

#include "bench.h"
#include "trace/tracer.h"

/* What an example scene needs for the ball: the item that follows its objects. */
static const struct beside {
    const char *scene, *object;
} beside[] = {
    {"room", "objects.4={name: ball, geometry: ball, at: [0, 0, -50], surface: white, "
             "outside: air, inside: ball}"},
    {"double-gauss", "objects.5={name: ball, geometry: ball, at: [0, 0, -500], surface: black, "
                     "outside: air, inside: ball}"},
};

enum { UNIFORM, GRADIENT, WAYS };
static const char *const filling[WAYS] = {"media.ball={index: 1.5}",
                                          "media.ball={gradient: {type: luneburg, radius: 1}}"};

/* Processor seconds of so many rays. */
static enum rmap_status trace(const struct rmap_bench_scene *scene, uint64_t n_ray, double *seconds,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_tally *tally = NULL;
    struct rmap_tally_recorder silent;
    struct rmap_tracer tracer = {.scene = scene->scene, .accel = scene->accel, .seed = 1};
    RMAP_TRY(rmap_tally_create(scene->scene, &tally, err));
    rmap_tally_recorder_init(&silent, tally, NULL);
    double begun = rmap_bench_cpu();
    for (uint64_t ray = 0; ray < n_ray; ray++)
        rmap_trace_ray(&tracer, ray, &silent.base);
    *seconds = rmap_bench_cpu() - begun;
out:
    rmap_tally_destroy(tally);
    return st;
}

enum rmap_status rmap_bench_uniform(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                    const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_scene way[WAYS] = {{.name = scene->name}, {.name = scene->name}};
    struct rmap_bench_series series = {0};
    const uint64_t n_ray = bench->quick ? 20000 : 100000;
    const size_t n_beside = sizeof beside / sizeof beside[0];
    size_t which = 0;
    while (which < n_beside && strcmp(beside[which].scene, scene->name) != 0)
        which++;
    if (which == n_beside)
        goto out;
    for (int w = 0; w < WAYS; w++) {
        const char *const set[] = {filling[w], "geometries.ball={type: sphere, radius: 1}",
                                   beside[which].object};
        RMAP_TRY(rmap_bench_load(bench, path, set, 3, &way[w], err));
    }
    for (int i = 0; i < bench->n_repeat; i++) {
        double seconds[WAYS];
        for (int k = 0; k < WAYS; k++) { /* in turns, either first */
            int w = (i + k) % WAYS;
            RMAP_TRY(trace(&way[w], n_ray, &seconds[w], err));
        }
        double n = 1e-6 * (double)n_ray;
        rmap_bench_add(&series, n / seconds[GRADIENT], n / seconds[UNIFORM]);
        rmap_bench_add_cpu(&series, seconds[GRADIENT], seconds[UNIFORM]);
    }
    rmap_bench_report(bench, "uniform_vs_gradient_code", scene, &series, "million rays/s per core",
                      NULL);
out:
    for (int w = 0; w < WAYS; w++)
        rmap_bench_scene_fini(&way[w]);
    return st;
}
