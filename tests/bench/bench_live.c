/* SPDX-License-Identifier: MIT
 *
 * A scene that lives: 20,968 instances of 53 meshes of 303,000 triangles. One instance is moved
 * until rays can be traced, against building everything; rays after a hundred moves, against
 * those in a structure made anew; and a start with meshes kept of an earlier one, of this scene and
 * of a mesh of a million triangles.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "accel/accel.h"
#include "base/alloc.h"
#include "bench.h"
#include "mpi/command/load.h"
#include "mpi/parallel/progress.h"
#include "portion/portion_recorder.h"
#include "scene/scene_edit.h"
#include "trace/tracer.h"

enum { N_MESH = 53, N_INSTANCE = 20968, N_MOVE = 100 };

/* Of a mesh's vertices around and along its axis. */
struct net {
    int n_around, n_along;
};
static const struct net of_instances = {53, 55}, of_large = {707, 709};

bool rmap_bench_wants_live(const struct rmap_bench *bench)
{
    return rmap_bench_wanted(bench, "move_vs_build") ||
           rmap_bench_wanted(bench, "moved_trace_vs_fresh") ||
           rmap_bench_wanted(bench, "cache_vs_none");
}

/* A ball with bumps. */
static void vertex_of(struct net net, int mesh, int along, int around, float v[3])
{
    const double theta = RMAP_PI * along / net.n_along, phi = 2 * RMAP_PI * around / net.n_around,
                 s = sin(theta), r = 1 + 0.1 * sin(3 * theta + mesh) * cos(2 * phi + mesh) * s;
    v[0] = (float)(r * s * cos(phi));
    v[1] = (float)(r * s * sin(phi));
    v[2] = (float)(r * cos(theta));
}

static void write_triangle(FILE *out, struct net net, int mesh, const int corner[3][2])
{
    float number[12] = {0};
    const uint16_t none = 0;
    for (int k = 0; k < 3; k++) /* the poles are one point each */
        vertex_of(net, mesh, corner[k][0],
                  corner[k][0] % net.n_along == 0 ? 0 : corner[k][1] % net.n_around,
                  &number[3 + 3 * k]);
    (void)fwrite(number, sizeof number, 1, out);
    (void)fwrite(&none, sizeof none, 1, out);
}

static bool write_mesh(const char *folder, struct net net, int mesh)
{
    char path[640], head[80] = "a ball";
    const uint32_t n = (uint32_t)(2 * net.n_around * (net.n_along - 1));
    (void)snprintf(path, sizeof path, "%s/m%d.stl", folder, mesh);
    FILE *out = fopen(path, "wb");
    if (!out)
        return false;
    (void)fwrite(head, sizeof head, 1, out);
    (void)fwrite(&n, sizeof n, 1, out);
    for (int i = 0; i < net.n_along; i++)
        for (int j = 0; j < net.n_around; j++) {
            const int down[3][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}},
                      up[3][2] = {{i, j}, {i + 1, j + 1}, {i, j + 1}};
            if (i + 1 < net.n_along)
                write_triangle(out, net, mesh, down);
            if (i > 0)
                write_triangle(out, net, mesh, up);
        }
    const bool good = !ferror(out);
    return fclose(out) == 0 && good;
}

/* Of so many objects, which share N_MESH meshes. */
static enum rmap_status write_scene(const char *folder, struct net net, int n_object, char *path,
                                    size_t path_nbytes, struct rmap_error *err)
{
    const int n_mesh = n_object < N_MESH ? n_object : N_MESH;
    (void)snprintf(path, path_nbytes, "%s/live.yaml", folder);
    FILE *out = fopen(path, "w");
    bool good = out != NULL;
    if (good)
        fprintf(out, "raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}}\n"
                     "surfaces: {white: {type: lambert, reflectance: 0.6}}\ngeometries:\n");
    for (int i = 0; i < n_mesh && good; i++) {
        good = write_mesh(folder, net, i);
        fprintf(out, "  m%d: {type: mesh, file: m%d.stl}\n", i, i);
    }
    if (good)
        fprintf(out, "objects:\n");
    for (int i = 0; i < n_object && good; i++)
        fprintf(out,
                "  - {name: o%d, geometry: m%d, at: [%.3f, %.3f, %d], rotate: [%d, %d, %d], "
                "surface: white, outside: air, inside: glass}\n",
                i, i % N_MESH, 3 * (i % 28) + 0.1 * (i % 7), 3 * (i / 28 % 28) + 0.1 * (i % 5),
                3 * (i / 784), i % 360, 7 * i % 360, 13 * i % 360);
    if (good)
        fprintf(out, "sources:\n  - {name: a, type: point, at: [40.5, 40.5, 37.5], medium: air}\n");
    good = good && !ferror(out);
    if ((out && fclose(out) != 0) || !good)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write %s", path);
    return RMAP_OK;
}

struct cost {
    double wall_s, cpu_s;
};

static struct cost now(void)
{
    return (struct cost){rmap_clock_seconds(), rmap_bench_cpu()};
}

static struct cost since(struct cost begun)
{
    return (struct cost){rmap_clock_seconds() - begun.wall_s, rmap_bench_cpu() - begun.cpu_s};
}

/* The k-th instance goes a little aside. */
static enum rmap_status move_one(struct rmap_bench_scene *scene, int k, struct cost *cost,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene_part part = {.object = (int32_t)(207 * (k % N_MOVE)), .group = -1};
    struct rmap_affine placement = scene->scene->object[part.object].standing.placement;
    int32_t *moved = NULL;
    size_t n_moved = 0;
    placement.t.x += 0.05 * (k % 3 - 1);
    placement.t.z += 0.4;
    const struct cost begun = now();
    RMAP_TRY(rmap_scene_move(scene->scene, part, &placement, &moved, &n_moved, err));
    RMAP_TRY(rmap_accel_move(scene->accel, moved, n_moved, err));
    *cost = since(begun);
out:
    rmap_free(moved);
    return st;
}

static enum rmap_status trace(const struct rmap_scene *scene, const struct rmap_accel *accel,
                              uint64_t n_ray, struct cost *cost, struct rmap_digest *digest,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    const struct rmap_tracer tracer = {scene, accel, 1};
    RMAP_TRY(rmap_portion_create((size_t)n_ray, scene->channels.n, &portion, err));
    rmap_portion_recorder_init(&recorder, portion);
    const struct cost begun = now();
    for (uint64_t ray = 0; ray < n_ray; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    *cost = since(begun);
    if (recorder.status != RMAP_OK)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for rays"));
    *digest = rmap_portion_digest(portion);
out:
    rmap_portion_destroy(portion);
    return st;
}

static enum rmap_status measure_moves(struct rmap_bench *bench, struct rmap_bench_scene *scene,
                                      struct rmap_bench_series *series, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int i = 0, k = 0; i < bench->n_repeat; i++) {
        struct cost cost, sum = {0, 0};
        struct rmap_accel *fresh = NULL;
        for (int j = 0; j < N_MOVE; j++, k++) {
            RMAP_TRY(move_one(scene, k, &cost, err));
            sum.wall_s += cost.wall_s / N_MOVE;
            sum.cpu_s += cost.cpu_s / N_MOVE;
        }
        const struct cost begun = now();
        RMAP_TRY(rmap_accel_create(scene->scene, bench->alone.n_thread, &fresh, err));
        cost = since(begun);
        rmap_accel_destroy(fresh);
        rmap_bench_add(series, 1e3 * sum.cpu_s, 1e3 * cost.cpu_s);
        rmap_bench_add_cpu(series, sum.cpu_s, cost.cpu_s);
    }
out:
    return st;
}

/* Of a structure that has followed many moves. */
static enum rmap_status measure_rays(struct rmap_bench *bench, struct rmap_bench_scene *scene,
                                     struct rmap_bench_series *series, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t n_ray = bench->quick ? 20000 : 100000;
    struct rmap_accel *fresh = NULL;
    RMAP_TRY(rmap_accel_create(scene->scene, bench->alone.n_thread, &fresh, err));
    for (int i = 0; i < bench->n_repeat; i++) {
        struct cost ours = {0, 0}, reference;
        struct rmap_digest a = {0, 0}, b;
        if (i % 2)
            RMAP_TRY(trace(scene->scene, scene->accel, n_ray, &ours, &a, err));
        RMAP_TRY(trace(scene->scene, fresh, n_ray, &reference, &b, err));
        if (i % 2 == 0)
            RMAP_TRY(trace(scene->scene, scene->accel, n_ray, &ours, &a, err));
        if (memcmp(&a, &b, sizeof a) != 0)
            RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "the moved scene has other rays"));
        rmap_bench_add(series, (double)n_ray / ours.cpu_s, (double)n_ray / reference.cpu_s);
        rmap_bench_add_cpu(series, ours.cpu_s, reference.cpu_s);
    }
out:
    rmap_accel_destroy(fresh);
    return st;
}

/* Ready to trace. */
static enum rmap_status start(const struct rmap_bench *bench, const char *path, const char *cache,
                              struct cost *cost, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_scene scene = {0};
    struct rmap_scene_options options = {0};
    struct rmap_context context = bench->alone;
    context.cache = cache;
    const struct cost begun = now();
    RMAP_TRY(rmap_load_scene(&context, path, &options, &scene.bundle, &scene.scene, err));
    RMAP_TRY(rmap_accel_create(scene.scene, context.n_thread, &scene.accel, err));
    *cost = since(begun);
out:
    rmap_bench_scene_fini(&scene);
    return st;
}

static enum rmap_status measure_starts(struct rmap_bench *bench, const char *name, const char *path,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_bench_scene scene = {.name = name};
    struct rmap_bench_series series = {0};
    struct cost ours, reference;
    char cache[600];
    (void)snprintf(cache, sizeof cache, "%s/kept", bench->folder);
    RMAP_TRY(start(bench, path, cache, &ours, err)); /* makes it */
    for (int i = 0; i < bench->n_repeat; i++) {
        if (i % 2)
            RMAP_TRY(start(bench, path, cache, &ours, err));
        RMAP_TRY(start(bench, path, NULL, &reference, err));
        if (i % 2 == 0)
            RMAP_TRY(start(bench, path, cache, &ours, err));
        rmap_bench_add(&series, ours.cpu_s, reference.cpu_s);
    }
    rmap_bench_report(bench, "cache_vs_none", &scene, &series, "s", NULL);
out:
    return st;
}

/* Of the instances, then of a large mesh, whose files take the place of theirs. */
static enum rmap_status measure_cache(struct rmap_bench *bench, const char *path,
                                      struct rmap_error *err)
{
    char large[600];
    enum rmap_status st = measure_starts(bench, "instances", path, err);
    if (st == RMAP_OK && !bench->quick)
        st = write_scene(bench->folder, of_large, 1, large, sizeof large, err);
    if (st == RMAP_OK && !bench->quick)
        st = measure_starts(bench, "large mesh", large, err);
    return st;
}

enum rmap_status rmap_bench_live(struct rmap_bench *bench, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char path[600];
    struct rmap_bench_scene scene = {.name = "instances"};
    struct rmap_bench_series moves = {0}, rays = {0};
    struct rmap_scene_options options = {0};
    RMAP_TRY(write_scene(bench->folder, of_instances, N_INSTANCE, path, sizeof path, err));
    RMAP_TRY(rmap_load_scene(&bench->alone, path, &options, &scene.bundle, &scene.scene, err));
    RMAP_TRY(rmap_accel_create(scene.scene, bench->alone.n_thread, &scene.accel, err));
    if (rmap_bench_wanted(bench, "move_vs_build") ||
        rmap_bench_wanted(bench, "moved_trace_vs_fresh"))
        RMAP_TRY(measure_moves(bench, &scene, &moves, err));
    if (rmap_bench_wanted(bench, "move_vs_build"))
        rmap_bench_report(bench, "move_vs_build", &scene, &moves, "ms", NULL);
    if (rmap_bench_wanted(bench, "moved_trace_vs_fresh")) {
        RMAP_TRY(measure_rays(bench, &scene, &rays, err));
        rmap_bench_report(bench, "moved_trace_vs_fresh", &scene, &rays, "rays/s", NULL);
    }
    if (rmap_bench_wanted(bench, "cache_vs_none"))
        RMAP_TRY(measure_cache(bench, path, err));
out:
    rmap_bench_scene_fini(&scene);
    return st;
}
