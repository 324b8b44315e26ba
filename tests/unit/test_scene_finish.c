/* SPDX-License-Identifier: MIT
 *
 * What rmap_scene_finish derives: bounds, schedule of sources, lists of detectors, areas; and
 * that it refuses what cannot be traced.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_scene.h"
#include "near.h"
#include "scene/vertex_grid.h"

static void finish(struct rmap_scene *scene)
{
    struct rmap_error err = {0};
    if (rmap_scene_finish(scene, &err) != RMAP_OK)
        fail_msg("%s", err.text);
}

static struct rmap_scene *with_sources(const double *share, int n)
{
    struct rmap_scene *scene = hand_scene(1);
    hand_medium(scene, 1.0);
    for (int i = 0; i < n; i++)
        hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(i, 0, 0), rmap_vec3(0, 0, 1))->share =
            share[i];
    return scene;
}

static void period_of_simple_shares(void **state)
{
    (void)state;
    static const struct {
        double share[3];
        int n;
        size_t period;
        uint64_t quota[3];
    } row[] = {
        {{1, 1, 1}, 3, 3, {1, 1, 1}},        {{1, 3}, 2, 4, {1, 3}},
        {{0.1, 0.2, 0.7}, 3, 10, {1, 2, 7}}, {{5}, 1, 1, {1}},
        {{1e-9, 1}, 2, 65536, {1, 65535}},
    };
    for (size_t k = 0; k < sizeof row / sizeof row[0]; k++) {
        struct rmap_scene *scene = with_sources(row[k].share, row[k].n);
        finish(scene);
        assert_int_equal(scene->schedule_len, row[k].period);
        for (int i = 0; i < row[k].n; i++)
            assert_int_equal(scene->schedule_quota[i], row[k].quota[i]);
        rmap_scene_destroy(scene);
    }
}

/* The quotas are the shares to one entry, and every prefix of ray ids keeps to the quotas. */
static void evenly_interleaved(void **state)
{
    (void)state;
    const double share[] = {1.0, 3.14159265, 0.5, 7.0};
    struct rmap_scene *scene = with_sources(share, 4);
    finish(scene);
    assert_int_equal(scene->schedule_len, 65536);
    double total = share[0] + share[1] + share[2] + share[3], count[4] = {0}, rate[4];
    for (int i = 0; i < 4; i++) {
        assert_near((double)scene->schedule_quota[i], share[i] / total * 65536.0, 1.0);
        rate[i] = (double)scene->schedule_quota[i] / 65536.0;
    }
    for (uint64_t ray = 0; ray < 200000; ray++) {
        uint64_t ordinal;
        int32_t source = rmap_scene_source_of(scene, ray, &ordinal);
        assert_true((double)ordinal == count[source]); /* consecutive: 0, 1, 2, ... */
        count[source] += 1.0;
        for (int i = 0; i < 4; i++)
            assert_near(count[i], rate[i] * (double)(ray + 1), 2.0);
    }
    rmap_scene_destroy(scene);
}

static void bounding_sphere(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    hand_medium(scene, 1.0);
    int32_t surface = hand_surface(scene, RMAP_SURFACE_ABSORBER);
    struct rmap_affine big =
        rmap_affine_placement(rmap_vec3(2, 2, 2), rmap_vec3(0, 90, 0), rmap_vec3(100, 0, 0));
    hand_object(scene, hand_rectangle(scene, 10, 20), surface, big, 0, 0);
    struct rmap_source *disc =
        hand_source(scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, -50), rmap_vec3(0, 0, 1));
    disc->shape = RMAP_EMITTER_DISC;
    disc->shape_size[0] = 30;
    hand_detector(scene, rmap_vec3(0, 0, 300), -1.0, 8.0);
    finish(scene);
    const struct rmap_vec3 inside[] = {{100, 20, 10}, {100, -20, -10}, {30, 0, -50},
                                       {0, 30, -50},  {4, 4, 300},     {-4, -4, 300}};
    for (size_t i = 0; i < sizeof inside / sizeof inside[0]; i++)
        assert_true(rmap_length(rmap_sub(inside[i], scene->centre)) < scene->radius);
    assert_true(scene->radius < 250.0);
    rmap_scene_destroy(scene);
}

static void a_scene_that_is_a_point(void **state)
{
    (void)state;
    const double share[] = {1};
    struct rmap_scene *scene = with_sources(share, 1);
    finish(scene);
    assert_true(scene->radius > 0.0);
    rmap_scene_destroy(scene);
}

static void detectors_by_kind(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    hand_medium(scene, 1.0);
    int32_t surface = hand_surface(scene, RMAP_SURFACE_ABSORBER);
    int32_t geometry = hand_rectangle(scene, 1, 1);
    scene->n_group = 2; /* group 1 within group 0 */
    scene->group[0].parent = -1;
    scene->group[1].parent = 0;
    for (int i = 0; i < 3; i++)
        hand_object(scene, geometry, surface, hand_shift(i, 0, 0), 0, 0);
    scene->object[1].parent = 1;
    scene->object[2].parent = 0;
    hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0)->type = RMAP_DETECTOR_INTENSITY;
    hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0)->on_group = 0;
    hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0);
    hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0)->on_object = 1;
    hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0)->on_group = 1;
    finish(scene);
    assert_true(rmap_scene_in_group(scene, 1, 0) && rmap_scene_in_group(scene, 1, 1));
    assert_true(rmap_scene_in_group(scene, 2, 0) && !rmap_scene_in_group(scene, 2, 1));
    assert_false(rmap_scene_in_group(scene, 0, 0));
    assert_int_equal(scene->n_far_detector, 1);
    assert_int_equal(scene->far_detector[0], 0);
    assert_int_equal(scene->n_free_detector, 1);
    assert_int_equal(scene->free_detector[0], 2);
    const size_t first[] = {0, 0, 3, 4};
    const int32_t on[] = {1, 3, 4, 1};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(scene->on_first[i], first[i]);
        assert_int_equal(scene->on_detector[i], on[i]);
    }
    rmap_scene_destroy(scene);
}

static void refuses(struct rmap_scene *scene)
{
    struct rmap_error err = {0};
    assert_int_equal(rmap_scene_finish(scene, &err), RMAP_INPUT);
    assert_true(err.text[0] != 0);
    rmap_scene_destroy(scene);
}

static void refusals(void **state)
{
    (void)state;
    const double one[] = {1}, zero[] = {0};
    struct rmap_scene *scene = with_sources(one, 1);
    hand_object(scene, hand_rectangle(scene, 1, 1), hand_surface(scene, RMAP_SURFACE_ABSORBER),
                rmap_affine_placement(rmap_vec3(1, 0, 1), rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 0)),
                0, 0);
    refuses(scene);
    scene = with_sources(one, 1);
    scene->source[0].frame.t.y = (double)NAN;
    refuses(scene);
    scene = with_sources(one, 1);
    hand_detector(scene, rmap_vec3(0, 0, HUGE_VAL), 1.0, 1.0);
    refuses(scene);
    refuses(with_sources(zero, 1));
    scene = with_sources(one, 1); /* an inverse of zeros */
    hand_object(scene, hand_rectangle(scene, 1e-159, 1e-159),
                hand_surface(scene, RMAP_SURFACE_ABSORBER),
                rmap_affine_placement(rmap_vec3(1e160, 1e160, 1e160), rmap_vec3(0, 0, 0),
                                      rmap_vec3(0, 0, 0)),
                0, 0);
    refuses(scene);
    scene = with_sources(one, 1);
    hand_object(scene, hand_rectangle(scene, 1e16, 1), hand_surface(scene, RMAP_SURFACE_ABSORBER),
                rmap_affine_identity(), 0, 0);
    refuses(scene);
    scene = with_sources(one, 1);
    scene->source[0].frame.t.y = 1e38;
    refuses(scene);
}

/* Of a ball, of a flat mesh and of a cloud; kind < 0: all vertices are one. */
static int32_t add_vertices(struct rmap_scene *scene, int kind, size_t n)
{
    struct rmap_mesh *mesh = NULL;
    const int32_t geometry = hand_rectangle(scene, 1, 1);
    assert_int_equal(rmap_mesh_create(n, 1, 1, &mesh, NULL), RMAP_OK);
    for (size_t i = 0; i < n && kind >= 0; i++) {
        const double turn = 2.4 * (double)i, z = 2 * ((double)i + 0.5) / (double)n - 1,
                     r = kind == 2 ? sin(0.7 * turn * turn) : sqrt(1 - z * z);
        mesh->vertex[i][0] = (float)(3 + r * cos(turn));
        mesh->vertex[i][1] = (float)(r * sin(turn));
        mesh->vertex[i][2] = kind == 1 ? 0.25F : (float)z;
    }
    scene->geometry[geometry].kind = RMAP_GEOMETRY_MESH;
    scene->geometry[geometry].mesh = mesh;
    return geometry;
}

static struct rmap_affine turned(int k)
{
    struct rmap_affine a = hand_shift(1e3 * sin(k), k % 4 ? 1e9 : 0, cos(k));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            a.m[i][j] = k % 5 ? sin(1 + 7 * k + 3 * i + j) : (i + k) % 3 == j ? -1.5 : 0;
    return a;
}

static bool same_box(const struct rmap_bounds *a, const struct rmap_bounds *b)
{
    return a->lower.x == b->lower.x && a->lower.y == b->lower.y && a->lower.z == b->lower.z &&
           a->upper.x == b->upper.x && a->upper.y == b->upper.y && a->upper.z == b->upper.z &&
           a->infinite == b->infinite;
}

/* The box of an instance is that of its vertices, to the last digit, however many share the mesh.
 */
static void boxes_of_instances(void **state)
{
    (void)state;
    enum { N = 30 };
    for (int kind = -1; kind < 3; kind++) {
        struct rmap_scene *scene = hand_scene(1);
        hand_medium(scene, 1.0);
        const int32_t geometry = add_vertices(scene, kind, 2000),
                      surface = hand_surface(scene, RMAP_SURFACE_ABSORBER);
        const struct rmap_geometry *mesh = &scene->geometry[geometry];
        struct rmap_vertex_grid *grid = rmap_vertex_grid_create(mesh->mesh);
        struct rmap_bounds box, whole;
        struct rmap_affine huge = turned(1);
        assert_non_null(grid);
        for (int k = 0; k < N; k++)
            (void)hand_object(scene, geometry, surface, turned(k), 0, 0);
        assert_int_equal(rmap_scene_bound_objects(scene, NULL), RMAP_OK);
        for (int k = 0; k < N; k++) {
            whole = rmap_bounds_empty();
            rmap_bounds_include_geometry(&whole, mesh, &scene->object[k].to_world);
            assert_true(rmap_vertex_grid_bounds(grid, &scene->object[k].to_world, &box));
            assert_true(same_box(&box, &whole) && same_box(&scene->object_bounds[k], &whole));
        }
        huge.m[1][1] = 1e308;
        assert_false(rmap_vertex_grid_bounds(grid, &huge, &box));
        huge.m[1][1] = NAN;
        assert_false(rmap_vertex_grid_bounds(grid, &huge, &box));
        rmap_vertex_grid_destroy(grid);
        rmap_scene_destroy(scene);
    }
}

/* Whichever allocation fails, the scene is refused and released whole. */
static void memory_runs_short(void **state)
{
    (void)state;
    const double share[] = {1, 2};
    int64_t before = rmap_alloc_live();
    enum rmap_status st = RMAP_SYSTEM;
    int64_t fail_at = 1;
    for (; st != RMAP_OK; fail_at++) {
        struct rmap_scene *scene = with_sources(share, 2);
        hand_detector(scene, rmap_vec3(0, 0, 1), 1.0, 1.0);
        rmap_alloc_fail_at(fail_at);
        st = rmap_scene_finish(scene, NULL);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        rmap_scene_destroy(scene);
        assert_int_equal(rmap_alloc_live(), before);
    }
    assert_true(fail_at > 5);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(period_of_simple_shares), cmocka_unit_test(evenly_interleaved),
        cmocka_unit_test(bounding_sphere),         cmocka_unit_test(a_scene_that_is_a_point),
        cmocka_unit_test(detectors_by_kind),       cmocka_unit_test(refusals),
        cmocka_unit_test(boxes_of_instances),      cmocka_unit_test(memory_runs_short),
    };
    return cmocka_run_group_tests_name("scene_finish", test, NULL, NULL);
}
