/* SPDX-License-Identifier: MIT
 *
 * Few analytic surfaces are found through the prefilter, many through Embree: the hits are the
 * same, bit for bit. Below AVX2 the accelerator has no prefilter.
 */
#include <math.h>

#include "build_scene.h"

enum { WITHOUT_PREFILTER = 2, WITH_PREFILTER = 3, N_KIND = 7, N_RAY = 20000, N_SEGMENT = 6 };

static void set_kinds(struct builder *b, int32_t kind[N_KIND])
{
    const struct rmap_shape shape[N_KIND] = {
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.2, .conic = -0.5, .aperture = 3},
        {.type = RMAP_SHAPE_CONIC, .curvature = -0.1, .aperture = 4, .inner = 1},
        {.type = RMAP_SHAPE_CONIC,
         .curvature = 0.1,
         .aperture = 3,
         .asphere = {0, 1e-3},
         .n_asphere = 2},
        {.type = RMAP_SHAPE_DISC, .aperture = 4, .inner = 3},
        {.type = RMAP_SHAPE_RECTANGLE, .size = {5, 2}},
        {.type = RMAP_SHAPE_TUBE, .radius = 4, .radius2 = 3, .length = 2},
        {.type = RMAP_SHAPE_SPHERE, .radius = 1},
    };
    for (int k = 0; k < N_KIND; k++)
        kind[k] = builder_shape(b, shape[k]);
}

/* n_row surfaces one behind the other along a tilted axis, n_loose anywhere, in a box. */
static void open_bench(struct builder *b, int n_row, int n_loose)
{
    const struct rmap_vec3 tilt = rmap_vec3(20, 30, 40), even = rmap_vec3(1, 1, 1);
    const struct rmap_affine axis = rmap_affine_placement(even, tilt, rmap_vec3(0, 0, 0));
    int32_t kind[N_KIND];
    builder_open(b, 64);
    set_kinds(b, kind);
    int32_t cube = builder_mesh(b, make_cube(1));
    builder_object(
        b, cube,
        rmap_affine_placement(rmap_vec3(60, 60, 60), rmap_vec3(0, 0, 0), rmap_vec3(1, 2, 3)), 0, 0);
    for (int k = 0; k < n_row; k++) { /* not in the order in which they stand */
        struct rmap_vec3 at = rmap_vec3(0.1 * k, 0, 1.7 * ((5 * k) % n_row) - 20);
        builder_object(b, kind[k % N_KIND],
                       rmap_affine_placement(even, tilt, rmap_affine_point(&axis, at)), 0, 0);
    }
    for (int k = 0; k < n_loose; k++) {
        double u[4];
        rmap_rng(31, (uint64_t)k, 0, RMAP_RNG_EMIT_POINT, u);
        builder_object(b, kind[k % N_KIND],
                       rmap_affine_placement(
                           rmap_vec3(1 + u[0], k % 2 ? 1 + u[1] : -1, 1 + u[2]),
                           rmap_vec3(360 * u[1], 360 * u[2], 360 * u[3]),
                           rmap_vec3(50 * (u[0] - 0.5), 50 * (u[1] - 0.5), 50 * (u[3] - 0.5))),
                       0, 0);
    }
    builder_close(b);
}

/* Every third ray runs along the row's axis, or across it, to the last digit. */
static struct rmap_vec3 first_direction(const struct builder *b, uint64_t i)
{
    const struct rmap_affine *frame = &b->scene->object[1].to_world;
    if (i % 3)
        return any_direction(i, 0);
    double sign = i % 2 ? 1 : -1;
    return rmap_normalize(
        rmap_affine_vector(frame, i % 4 < 2 ? rmap_vec3(0, 0, sign) : rmap_vec3(sign, 0, 0)));
}

static int compare_paths(const struct builder *b, const struct rmap_accel *other)
{
    int n_hit = 0;
    for (uint64_t i = 0; i < N_RAY; i++) {
        struct rmap_vec3 from = rmap_scale(any_direction(i, 99), i % 2 ? 3 : 25);
        struct rmap_ray ray = {.origin = from, .direction = first_direction(b, i)};
        for (uint32_t segment = 0; segment < N_SEGMENT; segment++) {
            struct rmap_hit hit, expected;
            memset(&hit, 0, sizeof(hit));
            memset(&expected, 0, sizeof(expected));
            bool met = rmap_accel_next(b->accel, &ray, &hit);
            assert_int_equal(met, rmap_accel_next(other, &ray, &expected));
            if (!met)
                break;
            assert_memory_equal(&hit, &expected, sizeof(hit));
            n_hit += hit.object > 0;
            ray.origin = hit.position;
            if ((i + segment) % 2) {
                rmap_contact_pass(&ray.contact, &hit);
                continue;
            }
            rmap_contact_turn(&ray.contact, &hit);
            double sign = rmap_dot(hit.normal, ray.direction) > 0 ? -1 : 1;
            ray.direction =
                rmap_normalize(rmap_axpy(1.1 * sign, hit.normal, any_direction(i, segment + 1)));
        }
    }
    return n_hit;
}

static void test_the_prefilter_finds_what_embree_finds(void **state)
{
    (void)state;
    const int size[][2] = {{21, 29}, {0, 9}, {14, 0}, {1, 0}, {57, 0}, {56, 1}, {8, 49}};
    if (rmap_accel_isa_level() < WITH_PREFILTER)
        skip();
    for (size_t k = 0; k < sizeof(size) / sizeof(size[0]); k++) {
        struct builder b;
        struct rmap_accel *plain = NULL;
        struct rmap_error err = {0};
        open_bench(&b, size[k][0], size[k][1]);
        assert_int_equal(rmap_accel_create_isa(b.scene, 1, WITHOUT_PREFILTER, &plain, &err),
                         RMAP_OK);
        assert_true(compare_paths(&b, plain) > (size[k][0] + size[k][1]) * 50);
        rmap_accel_destroy(plain);
        builder_destroy(&b);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Balls in and beside one another, some of which touch, over a block that is a mesh. */
static void open_balls(struct builder *b, int n)
{
    const double radius[] = {2, 1, 1, 0.5, 1.5, 0.01, 3, 1};
    const double x[] = {0, 0, 2, 2, -3, 0, 20, 0.999};
    struct rmap_vec3 no = rmap_vec3(0, 0, 0);
    builder_open(b, 16);
    builder_object(b, builder_mesh(b, make_cube(4)),
                   rmap_affine_placement(rmap_vec3(1, 1, 1), no, rmap_vec3(0, 0, -8)), 0, 0);
    for (int k = 0; k < n; k++) {
        int32_t ball = builder_shape(
            b, (struct rmap_shape){.type = RMAP_SHAPE_SPHERE, .radius = radius[k % 8]});
        builder_object(b, ball,
                       rmap_affine_placement(rmap_vec3(1, 1, k % 3 ? 1 : -1),
                                             rmap_vec3(10 * k, 20 * k, 0),
                                             rmap_vec3(x[k % 8], 5 * (k / 8), 0)),
                       0, 0);
    }
    builder_close(b);
}

/* Chords that end before, on, and behind the next surface. */
static void compare_chords(const struct builder *b, const struct rmap_accel *other)
{
    const double beyond[] = {-0.5, -1e-5, -1e-8, -1e-13, 0, 1e-13, 1e-8, 0.5};
    for (uint64_t i = 0; i < N_RAY; i++) {
        double u[4];
        rmap_rng(32, i, 0, RMAP_RNG_EMIT_POINT, u);
        struct rmap_ray ray = {.origin = rmap_scale(any_direction(i, 99), i % 2 ? 3 * u[0] : 30),
                               .direction = any_direction(i, 0)};
        for (uint32_t segment = 0; segment < N_SEGMENT; segment++) {
            struct rmap_hit next;
            if (!rmap_accel_next(other, &ray, &next))
                break;
            for (size_t k = 0; next.t > 0 && k < sizeof(beyond) / sizeof(beyond[0]); k++) {
                struct rmap_hit hit, expected;
                memset(&hit, 0, sizeof(hit));
                memset(&expected, 0, sizeof(expected));
                double length = next.t * (1 + beyond[k]);
                bool met = rmap_accel_next_within(b->accel, &ray, length, &hit);
                assert_int_equal(met, rmap_accel_next_within(other, &ray, length, &expected));
                assert_memory_equal(&hit, &expected, sizeof(hit));
            }
            ray.origin = next.position;
            if (segment % 2) { /* from space, near the surface */
                ray.origin = rmap_axpy(1e-3 * u[2] * u[2] * u[2], ray.direction, ray.origin);
                rmap_contact_clear(&ray.contact);
                ray.direction = any_direction(i, segment + 1);
            } else {
                rmap_contact_pass(&ray.contact, &next);
            }
        }
    }
}

static void test_balls_are_met_by_chords_as_by_embree(void **state)
{
    (void)state;
    if (rmap_accel_isa_level() < WITH_PREFILTER)
        skip();
    for (int n = 1; n < 10; n++) { /* nine are no balls, but shells of the prefilter */
        struct builder b;
        struct rmap_accel *plain = NULL;
        struct rmap_error err = {0};
        open_balls(&b, n);
        assert_int_equal(rmap_accel_create_isa(b.scene, 1, WITHOUT_PREFILTER, &plain, &err),
                         RMAP_OK);
        assert_true(compare_paths(&b, plain) > 100);
        compare_chords(&b, plain);
        rmap_accel_destroy(plain);
        builder_destroy(&b);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_prefilter_finds_what_embree_finds),
        cmocka_unit_test(test_balls_are_met_by_chords_as_by_embree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
