/* SPDX-License-Identifier: MIT
 *
 * A scene in memory that is edited, object by object, and finished again gives the rays
 * that the edited text gives.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "accel/accel.h"
#include "portion/portion_recorder.h"
#include "tests/unit/read_text.h"
#include "trace/tracer.h"

#define SCENE(ball_at, ball_surface, radius, glow, share, size)                                    \
    "raymap: 1\nmedia: {air: {index: 1}, glass: {index: 1.5}, rod: {gradient: {type: parabolic, "  \
    "n0: 1.6, alpha: 0.05}}}\n"                                                                    \
    "surfaces: {white: {type: lambert, reflectance: " glow "}}\n"                                  \
    "geometries:\n"                                                                                \
    "  ball: {type: sphere, radius: " radius "}\n"                                                 \
    "  rod: {type: cylinder, radius: 2, length: 9}\n"                                              \
    "  wall: {type: rectangle, size: [90, 90]}\n"                                                  \
    "objects:\n"                                                                                   \
    "  - {name: ball, geometry: ball, at: " ball_at ", surface: " ball_surface                     \
    ", outside: air, inside: glass}\n"                                                             \
    "  - {name: rod, geometry: rod, at: [0, 0, 30], surface: fresnel, outside: air, inside: "      \
    "rod}\n"                                                                                       \
    "  - {name: wall, geometry: wall, at: [0, 0, 60], surface: white, front: air, back: air}\n"    \
    "sources:\n"                                                                                   \
    "  - {name: a, type: point, medium: air, rays_share: " share "}\n"                             \
    "  - {name: b, type: collimated, shape: {disc: 5}, at: [0, 0, -9], medium: air}\n"             \
    "detectors:\n"                                                                                 \
    "  - {name: d, type: plane, on: wall, cells: 9, size: " size "}\n"                             \
    "  - {name: e, type: plane, at: [0, 0, 55], cells: 9, size: 30}\n"                             \
    "  - {name: f, type: intensity, cells: 9}\n"

static const char before[] = SCENE("[0, 0, 20]", "fresnel", "4", "0.5", "1", "50");
static const char after[] = SCENE("[1, 2, 14]", "white", "6", "0.9", "3", "70");

static struct rmap_digest trace(const struct rmap_scene *scene)
{
    enum { N_RAY = 3000 };
    struct rmap_error err = {0};
    struct rmap_accel *accel = NULL;
    struct rmap_portion *portion = NULL;
    struct rmap_portion_recorder recorder;
    assert_int_equal(rmap_accel_create(scene, 1, &accel, &err), RMAP_OK);
    assert_int_equal(rmap_portion_create(N_RAY, scene->channels.n, &portion, &err), RMAP_OK);
    const struct rmap_tracer tracer = {scene, accel, 5};
    rmap_portion_recorder_init(&recorder, portion);
    for (uint64_t ray = 0; ray < N_RAY; ray++)
        rmap_trace_ray(&tracer, ray, &recorder.base);
    assert_int_equal(recorder.status, RMAP_OK);
    struct rmap_digest digest = rmap_portion_digest(portion);
    rmap_portion_destroy(portion);
    rmap_accel_destroy(accel);
    return digest;
}

static void assert_alike(const struct rmap_scene *a, const struct rmap_scene *b, bool alike)
{
    struct rmap_digest x = trace(a), y = trace(b);
    assert_int_equal(memcmp(&x, &y, sizeof x) == 0, alike);
    assert_int_equal(a->radius == b->radius && a->schedule_len == b->schedule_len, alike);
}

static void test_edited_is_read_anew(void **state)
{
    char *told[2];
    struct rmap_error err = {0};
    struct rmap_scene *scene = read_text(before, &told[0]), *wanted = read_text(after, &told[1]);
    (void)state;
    assert_non_null(scene);
    assert_non_null(wanted);
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_OK); /* nothing changed */
    assert_alike(scene, wanted, false);
    scene->object[0].to_world =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(0, 0, 0), rmap_vec3(1, 2, 14));
    scene->object[0].surface_front = scene->object[0].surface_back = scene->object[2].surface_front;
    scene->geometry[scene->object[0].geometry].shape.radius = 6;
    for (int c = 0; c < scene->channels.n; c++)
        scene->surface[scene->object[2].surface_front].reflect_diffuse[c] = 0.9;
    scene->source[0].share = 3;
    scene->detector[0].size[0] = scene->detector[0].size[1] = 70;
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_OK);
    assert_alike(scene, wanted, true);
    free(told[0]);
    free(told[1]);
    rmap_scene_destroy(scene);
    rmap_scene_destroy(wanted);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_edited_is_read_anew)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
