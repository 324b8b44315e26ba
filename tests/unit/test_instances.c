/* SPDX-License-Identifier: MIT
 *
 * Analytic surfaces through their instances: small and far, mirrored, sheared, unevenly scaled.
 * The same answers from any thread and any instruction set.
 */
#include <math.h>

#include "base/workers.h"
#include "build_scene.h"

/* Architecture.md's trap: a disc scaled by 0.01 and placed at 1e5. */
static void test_a_small_far_disc_is_always_hit(void **state)
{
    (void)state;
    struct builder b;
    builder_open(&b, 4);
    struct rmap_shape disc = {.type = RMAP_SHAPE_DISC, .aperture = 1};
    int32_t geometry = builder_shape(&b, disc);
    struct rmap_affine place = rmap_affine_placement(
        rmap_vec3(0.01, 0.01, 0.01), rmap_vec3(20, 50, -70), rmap_vec3(1e5, -1e5, 1e5));
    builder_object(&b, geometry, place, 0, 0);
    builder_object(&b, geometry, rmap_affine_identity(), 0, 0);
    builder_close(&b);
    int missed = 0, extra = 0;
    for (uint64_t i = 0; i < 50000; i++) {
        double u[4];
        rmap_rng(21, i, 0, RMAP_RNG_EMIT_POINT, u);
        /* 0.999999 of the radius is hit, 1.000001 is not: 1e-8 in the world, of 1e5 */
        double r = i % 2 ? 0.999999 : 1.000001;
        struct rmap_vec3 local =
            rmap_vec3(r * cos(2 * RMAP_PI * u[0]), r * sin(2 * RMAP_PI * u[0]), 0);
        struct rmap_vec3 to = rmap_affine_point(&place, local);
        struct rmap_vec3 from = rmap_axpy(3e5 * u[1] + 1, any_direction(i, 0), to);
        if (i % 3 == 0)
            from = rmap_vec3(100 * u[1], 100 * u[2], 100 * u[3] + 1);
        struct rmap_ray ray = {.origin = from, .direction = rmap_normalize(rmap_sub(to, from))};
        struct rmap_hit hit;
        /* a start rounded to 1e-11 and a cosine this small move the point by too much */
        if (fabs(rmap_dot(rmap_affine_vector(&place, rmap_vec3(0, 0, 100)), ray.direction)) < 0.05)
            continue;
        bool met = rmap_accel_next(b.accel, &ray, &hit) && hit.object == 0;
        missed += i % 2 && !met;
        extra += !(i % 2) && met;
    }
    if (missed || extra)
        fail_msg("%d missed, %d beside", missed, extra);
    builder_destroy(&b);
}

/* A sphere under any affine map is the ellipsoid |W (p - c)| = R: its own formula against ours. */
static void check_ellipsoid(struct rmap_affine place)
{
    struct builder b;
    builder_open(&b, 2);
    struct rmap_shape sphere = {.type = RMAP_SHAPE_SPHERE, .radius = 2};
    builder_object(&b, builder_shape(&b, sphere), place, 0, 1);
    builder_close(&b);
    struct rmap_affine inverse;
    assert_true(rmap_affine_invert(&place, &inverse));
    int met = 0;
    for (uint64_t i = 0; i < 20000; i++) {
        double u[4];
        rmap_rng(22, i, 0, RMAP_RNG_EMIT_POINT, u);
        struct rmap_vec3 inside =
            rmap_affine_point(&place, rmap_scale(any_direction(i, 1), 2.4 * u[0]));
        struct rmap_vec3 d = any_direction(i, 0);
        struct rmap_vec3 from = rmap_axpy(-(9 + 9 * u[1]), d, inside);
        long double p[3], v[3], a = 0, h = 0, c = -4;
        const double pw[3] = {from.x, from.y, from.z}, dw[3] = {d.x, d.y, d.z};
        const double tw[3] = {inverse.t.x, inverse.t.y, inverse.t.z};
        for (int k = 0; k < 3; k++) {
            p[k] = tw[k];
            v[k] = 0;
            for (int j = 0; j < 3; j++) {
                p[k] += (long double)inverse.m[k][j] * pw[j];
                v[k] += (long double)inverse.m[k][j] * dw[j];
            }
            a += v[k] * v[k];
            h += p[k] * v[k];
            c += p[k] * p[k];
        }
        long double discriminant = h * h - a * c;
        if (fabsl(discriminant) < 1e-9L * h * h)
            continue;
        struct rmap_ray ray = {.origin = from, .direction = d, .medium = 0};
        struct rmap_hit hit;
        bool found = rmap_accel_next(b.accel, &ray, &hit);
        assert_int_equal(found, discriminant > 0);
        if (!found)
            continue;
        met++;
        double in = (double)((-h - sqrtl(discriminant)) / a);
        double out = (double)((-h + sqrtl(discriminant)) / a);
        double scale = 1e-12 * (fabs(in) + fabs(out) + rmap_length(place.t)) /
                       (double)sqrtl(discriminant / (h * h));
        if (fabs(hit.t - in) > scale)
            fail_msg("entry %.17g instead of %.17g", hit.t, in);
        assert_true(rmap_dot(hit.normal, d) < 0);
        rmap_contact_pass(&ray.contact, &hit);
        ray.origin = hit.position;
        assert_true(rmap_accel_next(b.accel, &ray, &hit));
        if (fabs(hit.t - (out - in)) > scale)
            fail_msg("chord %.17g instead of %.17g", hit.t, out - in);
        assert_true(rmap_dot(hit.normal, d) > 0);
        rmap_contact_pass(&ray.contact, &hit);
        ray.origin = hit.position;
        assert_false(rmap_accel_next(b.accel, &ray, &hit));
    }
    assert_true(met > 5000);
    builder_destroy(&b);
}

static void test_spheres_become_ellipsoids(void **state)
{
    (void)state;
    check_ellipsoid(
        rmap_affine_placement(rmap_vec3(1, 0.3, 2), rmap_vec3(10, 20, 30), rmap_vec3(1, 2, 3)));
    check_ellipsoid(
        rmap_affine_placement(rmap_vec3(-1, 1, 1), rmap_vec3(0, 0, 45), rmap_vec3(0, 0, 0)));
    check_ellipsoid(linear(1, 0.7, 0.2, 0, 1.3, -0.4, 0.1, 0, 0.8, rmap_vec3(-4, 1, 0)));
}

/* Hollow shapes stand in the scene as several boxes: every ray finds what the shape alone says. */
static void test_hollow_shapes_have_no_gaps(void **state)
{
    (void)state;
    const struct rmap_shape hollow[] = {
        {.type = RMAP_SHAPE_TUBE, .radius = 5, .radius2 = 5, .length = 9},
        {.type = RMAP_SHAPE_TUBE, .radius = 3, .radius2 = 6, .length = 4},
        {.type = RMAP_SHAPE_DISC, .aperture = 6, .inner = 5.5},
        {.type = RMAP_SHAPE_CONIC, .curvature = -0.1, .aperture = 9, .inner = 3},
    };
    const struct rmap_affine places[] = {
        rmap_affine_identity(),
        rmap_affine_placement(rmap_vec3(2, 0.5, -1), rmap_vec3(10, 40, 70), rmap_vec3(3, 2, 1))};
    for (int k = 0; k < 8; k++) {
        struct builder b;
        builder_open(&b, 2);
        const struct rmap_shape *shape = &hollow[k / 2];
        const struct rmap_affine *place = &places[k % 2];
        builder_object(&b, builder_shape(&b, *shape), *place, 0, 0);
        builder_close(&b);
        const struct rmap_affine *to_local = &b.scene->object[0].to_local;
        int met = 0;
        for (uint64_t i = 0; i < 40000; i++) {
            struct rmap_vec3 from = rmap_scale(any_direction(i, 1), 15);
            if (i % 2) /* from the middle */
                from = rmap_affine_point(place, any_direction(i, 2));
            double u[4];
            rmap_rng(24, i, 0, RMAP_RNG_EMIT_POINT, u);
            double r = shape->type == RMAP_SHAPE_TUBE ? shape->radius : shape->aperture;
            struct rmap_vec3 to = rmap_vec3(r * cos(7 * u[0]), r * sin(7 * u[0]), 4 * u[1]);
            if (i % 3)
                to = rmap_scale(to, 0.8 + 0.2 * u[2]);
            to = rmap_affine_point(place, to);
            struct rmap_ray ray = {.origin = from, .direction = rmap_normalize(rmap_sub(to, from))};
            struct rmap_shape_hit expected;
            struct rmap_hit hit;
            bool found = rmap_shape_intersect(shape, rmap_affine_point(to_local, ray.origin),
                                              rmap_affine_vector(to_local, ray.direction), false, 0,
                                              INFINITY, &expected);
            assert_int_equal(rmap_accel_next(b.accel, &ray, &hit), found);
            if (!found)
                continue;
            met++;
            assert_true(hit.t == expected.t);
        }
        assert_true(met > 500);
        builder_destroy(&b);
    }
}

enum { N_RAY = 20000, N_SEGMENT = 6 };

struct job {
    const struct builder *builder;
    struct rmap_hit *hit; /* [N_RAY * N_SEGMENT] */
};

static void trace(void *context, int thread)
{
    struct job *job = &((struct job *)context)[thread];
    for (uint64_t i = 0; i < N_RAY; i++) {
        struct rmap_ray ray = {.origin = {0, 0, 0.1}, .direction = any_direction(i, 0)};
        for (uint32_t segment = 0; segment < N_SEGMENT; segment++) {
            struct rmap_hit *hit = &job->hit[i * N_SEGMENT + segment];
            memset(hit, 0, sizeof(*hit));
            if (!rmap_accel_next(job->builder->accel, &ray, hit))
                break;
            ray.origin = hit->position;
            rmap_contact_turn(&ray.contact, hit);
            double sign = rmap_dot(hit->normal, ray.direction) > 0 ? -1 : 1;
            ray.direction =
                rmap_normalize(rmap_axpy(1.1 * sign, hit->normal, any_direction(i, segment + 1)));
        }
    }
}

static void open_crowd(struct builder *b)
{
    builder_open(b, 64);
    int32_t ball = builder_mesh(b, make_ball(9)), cube = builder_mesh(b, make_cube(1));
    struct rmap_shape sphere = {.type = RMAP_SHAPE_SPHERE, .radius = 1};
    int32_t kind[3] = {ball, cube, builder_shape(b, sphere)};
    builder_object(
        b, cube,
        rmap_affine_placement(rmap_vec3(30, 30, 30), rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 0)), 0, 0);
    for (uint64_t k = 0; k < 40; k++) {
        double u[4];
        rmap_rng(23, k, 0, RMAP_RNG_EMIT_POINT, u);
        builder_object(b, kind[k % 3],
                       rmap_affine_placement(
                           rmap_vec3(1 + u[0], 1 + u[1], 1 + u[2]),
                           rmap_vec3(360 * u[1], 360 * u[2], 360 * u[3]),
                           rmap_vec3(50 * (u[0] - 0.5), 50 * (u[1] - 0.5), 50 * (u[3] - 0.5))),
                       0, 0);
    }
    builder_close(b);
}

static void test_threads_and_instruction_sets_agree(void **state)
{
    (void)state;
    struct builder b;
    open_crowd(&b);
    struct job job[3] = {{.builder = &b}, {.builder = &b}, {.builder = &b}};
    for (int k = 0; k < 3; k++) {
        job[k].hit = rmap_alloc((size_t)N_RAY * N_SEGMENT, sizeof(*job[k].hit));
        assert_non_null(job[k].hit);
    }
    struct rmap_workers *workers = NULL;
    struct rmap_error err = {0};
    assert_int_equal(rmap_workers_start(2, trace, job, &workers, &err), RMAP_OK);
    rmap_workers_join(workers);
    size_t bytes = (size_t)N_RAY * N_SEGMENT * sizeof(*job[0].hit);
    assert_memory_equal(job[0].hit, job[1].hit, bytes);
    for (int level = 0; level <= rmap_accel_isa_level(); level++) {
        struct builder other = b;
        assert_int_equal(rmap_accel_create_isa(b.scene, 1, level, &other.accel, &err), RMAP_OK);
        assert_int_equal(rmap_accel_isa_level_of(rmap_accel_isa(other.accel)), level);
        job[2].builder = &other;
        trace(job, 2);
        rmap_accel_destroy(other.accel);
        assert_memory_equal(job[0].hit, job[2].hit, bytes);
    }
    for (int k = 0; k < 3; k++)
        rmap_free(job[k].hit);
    builder_destroy(&b);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_replay_counts_the_same_hits(void **state)
{
    (void)state;
    enum { N = 5000 };
    struct builder b;
    open_crowd(&b);
    struct rmap_replay_ray *ray = rmap_alloc(N, sizeof(*ray));
    assert_non_null(ray);
    size_t n_hit = 0;
    for (uint64_t i = 0; i < N; i++) {
        ray[i].ray.origin = rmap_scale(any_direction(i, 9), 80);
        ray[i].ray.direction = any_direction(i, 3);
        struct rmap_hit hit;
        n_hit += rmap_accel_next(b.accel, &ray[i].ray, &hit);
    }
    assert_true(n_hit > 100 && n_hit < N - 100);
    assert_int_equal(rmap_accel_prepare(b.accel, ray, N, NULL), RMAP_OK);
    assert_int_equal(rmap_accel_replay(b.accel, ray, N), n_hit);
    rmap_free(ray);
    builder_destroy(&b);
}

static void test_an_empty_scene_is_never_hit(void **state)
{
    (void)state;
    struct builder b;
    builder_open(&b, 1);
    builder_close(&b);
    struct rmap_ray ray = {.origin = {1, 2, 3}, .direction = {0, 0, 1}};
    struct rmap_hit hit;
    assert_false(rmap_accel_next(b.accel, &ray, &hit));
    builder_destroy(&b);
}

static void test_short_memory_is_an_error(void **state)
{
    (void)state;
    struct builder b;
    open_crowd(&b);
    struct rmap_accel *accel = NULL;
    struct rmap_error err = {0};
    int64_t live = rmap_alloc_live();
    for (int64_t k = 1; k < 40; k++) {
        rmap_alloc_fail_at(k);
        enum rmap_status st = rmap_accel_create(b.scene, 1, &accel, &err);
        rmap_alloc_fail_at(0);
        if (st == RMAP_OK) {
            assert_true(k > 5);
            rmap_accel_destroy(accel);
            break;
        }
        assert_int_equal(st, RMAP_SYSTEM);
        assert_int_equal(rmap_alloc_live(), live);
    }
    b.scene->geometry[0].mesh->triangle[5][1] = 1000000;
    assert_int_equal(rmap_accel_create(b.scene, 1, &accel, &err), RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), live);
    builder_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_small_far_disc_is_always_hit),
        cmocka_unit_test(test_spheres_become_ellipsoids),
        cmocka_unit_test(test_hollow_shapes_have_no_gaps),
        cmocka_unit_test(test_threads_and_instruction_sets_agree),
        cmocka_unit_test(test_replay_counts_the_same_hits),
        cmocka_unit_test(test_an_empty_scene_is_never_hit),
        cmocka_unit_test(test_short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
