/* SPDX-License-Identifier: MIT
 *
 * A hand-built scene with what it takes to trace rays through it. Include after cmocka.h.
 */
#ifndef HAND_BENCH_H
#define HAND_BENCH_H

#include "hand_scene.h"
#include "portion/history.h"
#include "trace/tracer.h"

/* Air is medium 0. Everything that a test owns. */
struct bench {
    struct rmap_scene *scene;
    struct rmap_accel *accel;
    struct rmap_tracer tracer;
    struct rmap_history history;
};

static inline void start(struct bench *bench)
{
    struct rmap_error err = {0};
    if (rmap_scene_finish(bench->scene, &err) != RMAP_OK ||
        rmap_accel_create(bench->scene, 1, &bench->accel, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    bench->tracer = (struct rmap_tracer){bench->scene, bench->accel, 2024};
    rmap_history_init(&bench->history, bench->scene->channels.n);
}

static inline void stop(struct bench *bench)
{
    rmap_history_fini(&bench->history);
    rmap_accel_destroy(bench->accel);
    rmap_scene_destroy(bench->scene);
}

static inline const struct rmap_history *trace(struct bench *bench, uint64_t ray)
{
    rmap_trace_ray(&bench->tracer, ray, &bench->history.base);
    assert_int_equal(bench->history.status, RMAP_OK);
    return &bench->history;
}

/* A slab of this index, 0 <= z <= thickness, in air (medium 0), both faces of one surface. */
static inline int32_t add_slab(struct rmap_scene *scene, double index, double thickness,
                               int32_t surface)
{
    int32_t glass = hand_medium(scene, index), face = hand_rectangle(scene, 1e4, 1e4);
    hand_object(scene, face, surface, hand_shift(0, 0, 0), glass, 0);
    hand_object(scene, face, surface, hand_shift(0, 0, thickness), 0, glass);
    return glass;
}

/* A thin beam from z = -10 at this angle to +z, in the x-z plane. */
static inline struct rmap_source *add_beam(struct rmap_scene *scene, double degrees)
{
    double a = degrees * RMAP_PI / 180.0;
    return hand_source(scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, -10),
                       rmap_vec3(sin(a), 0, cos(a)));
}

#endif
