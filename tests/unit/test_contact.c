/* SPDX-License-Identifier: MIT
 *
 * Faces that touch are crossed exactly once each, in either direction and after reflections;
 * sources on surfaces; diffuse light in closed rooms stays inside.
 */
#include <math.h>

#include "build_scene.h"

enum { AIR = 0, GLASS = 1, WATER = 2, BLACK = 3 };

static struct rmap_affine at(double x, double y, double z)
{
    struct rmap_affine a = rmap_affine_identity();
    a.t = rmap_vec3(x, y, z);
    return a;
}

/* Follows a straight ray through everything; "object+medium" of each crossing, as text. */
struct crossing {
    int32_t object, near_medium, far_medium;
    double t;
};

static int follow(const struct builder *b, struct rmap_ray *ray, struct crossing *list, int max)
{
    int n = 0;
    struct rmap_hit hit;
    while (n < max && rmap_accel_next(b->accel, ray, &hit)) {
        const struct rmap_object *o = &b->scene->object[hit.object];
        bool front = rmap_dot(hit.normal, ray->direction) < 0;
        list[n].object = hit.object;
        list[n].near_medium = front ? o->medium_front : o->medium_back;
        list[n].far_medium = front ? o->medium_back : o->medium_front;
        list[n].t = hit.t;
        n++;
        rmap_contact_pass(&ray->contact, &hit);
        ray->origin = hit.position;
        ray->medium = list[n - 1].far_medium;
    }
    return n;
}

static void expect_chain(const struct builder *b, struct rmap_ray ray, int32_t medium_in,
                         const int32_t *object, int n_object)
{
    struct crossing list[32];
    int32_t medium = medium_in;
    ray.medium = medium_in;
    int n = follow(b, &ray, list, 32);
    if (n != n_object)
        fail_msg("%d crossings instead of %d; first: object %d", n, n_object,
                 n ? list[0].object : -1);
    for (int i = 0; i < n; i++) {
        assert_int_equal(list[i].object, object[i]);
        assert_int_equal(list[i].near_medium, medium);
        medium = list[i].far_medium;
    }
}

/* Two boxes that share a face, in different frames and with different float roundings. */
static void open_boxes(struct builder *b, struct rmap_affine place, int32_t inside_0,
                       int32_t inside_1)
{
    builder_open(b, 4);
    int32_t cube = builder_mesh(b, make_cube(0.7));
    struct rmap_affine first = at(0.1, 0.2, -0.7), second = at(0.1, 0.2, 0.7);
    struct rmap_affine turn =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(0, 0, 90), rmap_vec3(0, 0, 0));
    second = rmap_affine_compose(&second, &turn);
    builder_object(b, cube, rmap_affine_compose(&place, &first), AIR, inside_0);
    builder_object(b, cube, rmap_affine_compose(&place, &second), AIR, inside_1);
    builder_close(b);
}

static void test_touching_boxes_are_crossed_once_each(void **state)
{
    (void)state;
    static const int32_t forward[] = {0, 0, 1, 1}, backward[] = {1, 1, 0, 0};
    const struct rmap_affine places[] = {
        rmap_affine_identity(),
        rmap_affine_placement(rmap_vec3(3, 3, 3), rmap_vec3(11, 23, 47), rmap_vec3(7, -5, 2)),
        rmap_affine_placement(rmap_vec3(-0.2, 1.7, 0.9), rmap_vec3(1, 2, 3), rmap_vec3(9, 8, 7)),
        rmap_affine_placement(rmap_vec3(0.01, 0.01, 0.01), rmap_vec3(5, 6, 7),
                              rmap_vec3(1e3, 2e3, -1e3))};
    /* a box of air in air is met where it stands, too */
    static const int32_t inside[][2] = {{GLASS, WATER}, {AIR, WATER}, {GLASS, AIR}};
    for (size_t m = 0; m < 3 * sizeof(places) / sizeof(places[0]); m++) {
        size_t k = m / 3;
        struct builder b;
        open_boxes(&b, places[k], inside[m % 3][0], inside[m % 3][1]);
        for (uint64_t i = 0; i < 7000; i++) {
            double u[4];
            rmap_rng(7, i, 0, RMAP_RNG_EMIT_POINT, u);
            struct rmap_vec3 low =
                rmap_vec3(0.1 + 0.9 * (u[0] - 0.5), 0.2 + 0.9 * (u[1] - 0.5), -3);
            struct rmap_vec3 high =
                rmap_vec3(0.1 + 0.9 * (u[2] - 0.5), 0.2 + 0.9 * (u[3] - 0.5), 3);
            if (i % 4 == 0) /* through the diagonal of the shared face */
                low.y = low.x + 0.1, high = rmap_vec3(low.x, low.y, 3);
            low = rmap_affine_point(&places[k], low);
            high = rmap_affine_point(&places[k], high);
            struct rmap_ray ray = {.origin = low};
            ray.direction = rmap_normalize(rmap_sub(high, low));
            expect_chain(&b, ray, AIR, forward, 4);
            ray = (struct rmap_ray){.origin = high};
            ray.direction = rmap_normalize(rmap_sub(low, high));
            expect_chain(&b, ray, AIR, backward, 4);
        }
        builder_destroy(&b);
    }
}

/* Four cubes of four media in a square, aimed at their shared edges, corners and faces: whatever
 * is crossed in whatever order, each face is met from the medium on its near side. */
static void test_edges_of_touching_boxes(void **state)
{
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        struct rmap_affine place = rmap_affine_placement(
            rmap_vec3(1, 1, 1), turned ? rmap_vec3(10, 20, 30) : rmap_vec3(0, 0, 0),
            rmap_vec3(1, 2, 3));
        struct builder b;
        builder_open(&b, 8);
        int32_t cube = builder_mesh(&b, make_cube(0.35));
        for (int k = 0; k < 4; k++) {
            struct rmap_affine local = at(0.7 * (k & 1), 0, 0.7 * (k >> 1));
            builder_object(&b, cube, rmap_affine_compose(&place, &local), AIR, 1 + k);
        }
        builder_close(&b);
        for (uint64_t i = 0; i < 100000; i++) {
            double u[4], v[4];
            rmap_rng(12, i, 0, RMAP_RNG_EMIT_POINT, u);
            rmap_rng(13, i, 0, RMAP_RNG_EMIT_POINT, v);
            struct rmap_vec3 to =
                rmap_vec3(0.35 * floor(5 * u[0]) - 0.35, 0.35 * floor(3 * u[1]) - 0.35,
                          0.35 * floor(5 * u[2]) - 0.35);
            if (i % 3 == 0)
                to.x = 1.4 * v[0] - 0.35;
            if (i % 4 == 0)
                to.z = 1.4 * v[1] - 0.35;
            struct rmap_vec3 d = i % 5 ? any_direction(i, 0) : rmap_vec3(0, 0, 1);
            if (i % 7 == 0)
                d = rmap_normalize(rmap_vec3(d.x, 0, d.z)); /* in the plane of two sides */
            struct rmap_ray ray = {.medium = AIR};
            ray.origin = rmap_affine_point(&place, rmap_axpy(-3 - 3 * v[3], d, to));
            ray.direction = rmap_normalize(rmap_affine_vector(&place, d));
            struct crossing list[32];
            int32_t medium = AIR;
            int n = follow(&b, &ray, list, 32);
            for (int k = 0; k < n; k++) {
                if (list[k].near_medium != medium)
                    fail_msg("ray %d, crossing %d: medium %d where %d was", (int)i, k,
                             list[k].near_medium, medium);
                medium = list[k].far_medium;
            }
            assert_int_equal(medium, AIR);
        }
        builder_destroy(&b);
    }
}

static struct rmap_vec3 mirrored(struct rmap_vec3 d, struct rmap_vec3 n)
{
    return rmap_axpy(-2 * rmap_dot(d, n), n, d);
}

/* Glass block, cemented water block, a black disc on the water's far side and a plate between. */
static void test_reflections_at_touching_faces(void **state)
{
    (void)state;
    struct builder b;
    open_boxes(&b, rmap_affine_identity(), GLASS, WATER);
    struct rmap_ray ray = {.origin = rmap_vec3(0.2, 0.4, -5), .direction = {0, 0, 1}};
    struct rmap_hit hit;
    /* enter the glass, meet its far side, turn back there: the water is not met */
    assert_true(rmap_accel_next(b.accel, &ray, &hit));
    rmap_contact_pass(&ray.contact, &hit);
    ray.origin = hit.position;
    ray.medium = GLASS;
    assert_true(rmap_accel_next(b.accel, &ray, &hit));
    assert_int_equal(hit.object, 0);
    struct rmap_ray turned = ray;
    rmap_contact_turn(&turned.contact, &hit);
    turned.origin = hit.position;
    turned.direction = mirrored(ray.direction, hit.normal);
    struct rmap_hit next;
    assert_true(rmap_accel_next(b.accel, &turned, &next));
    assert_int_equal(next.object, 0);
    assert_true(fabs(next.t - 1.4) < 1e-6);
    /* pass it, turn back at the water: the glass is met at once, then its near side */
    rmap_contact_pass(&ray.contact, &hit);
    ray.origin = hit.position;
    ray.medium = AIR;
    assert_true(rmap_accel_next(b.accel, &ray, &hit));
    assert_int_equal(hit.object, 1);
    assert_true(hit.t == 0);
    for (int bounce = 0; bounce < 6; bounce++) { /* to and fro in the gap of no width */
        rmap_contact_turn(&ray.contact, &hit);
        ray.origin = hit.position;
        ray.direction = mirrored(ray.direction, hit.normal);
        assert_true(rmap_accel_next(b.accel, &ray, &hit));
        assert_int_equal(hit.object, bounce % 2);
        assert_true(hit.t == 0);
    }
    rmap_contact_pass(&ray.contact, &hit);
    ray.origin = hit.position;
    ray.medium = WATER;
    assert_true(rmap_accel_next(b.accel, &ray, &hit));
    assert_int_equal(hit.object, 1);
    assert_true(fabs(hit.t - 1.4) < 1e-6);
    builder_destroy(&b);
}

/* A sensor that lies on the back of its cover glass, and a doublet cemented as two lenses: all
 * analytic, or with a mesh. */
static void test_discs_on_faces(void **state)
{
    (void)state;
    for (int mesh = 0; mesh < 2; mesh++) {
        struct builder b;
        builder_open(&b, 8);
        int32_t disc =
            builder_shape(&b, (struct rmap_shape){.type = RMAP_SHAPE_DISC, .aperture = 0.6});
        struct rmap_affine back = at(0.1, 0, 3.3);
        int32_t sensor = builder_object(&b, disc, back, AIR, AIR);
        if (mesh) {
            builder_object(&b, builder_mesh(&b, make_cube(0.7)), at(0.1, 0, 3.3 + 0.7), AIR, GLASS);
        } else {
            struct rmap_shape plate = {.type = RMAP_SHAPE_RECTANGLE, .size = {1.4, 1.4}};
            int32_t side = builder_shape(&b, plate);
            builder_object(&b, side, at(0.1, 0, 3.3), GLASS, AIR);
            builder_object(&b, side, at(0.1, 0, 3.3 + 1.4), AIR, GLASS);
        }
        builder_close(&b);
        static const int32_t down_mesh[] = {1, 1, 0}, up_mesh[] = {0, 1, 1};
        static const int32_t down_flat[] = {2, 1, 0}, up_flat[] = {0, 1, 2};
        assert_int_equal(sensor, 0);
        for (uint64_t i = 0; i < 5000; i++) {
            double u[4];
            rmap_rng(8, i, 0, RMAP_RNG_EMIT_POINT, u);
            struct rmap_vec3 top = rmap_vec3(0.1 + 0.4 * (u[0] - 0.5), 0.4 * (u[1] - 0.5), 9);
            struct rmap_vec3 low = rmap_vec3(0.1 + 0.4 * (u[2] - 0.5), 0.4 * (u[3] - 0.5), -2);
            struct rmap_ray ray = {.origin = top};
            ray.direction = rmap_normalize(rmap_sub(low, top));
            expect_chain(&b, ray, AIR, mesh ? down_mesh : down_flat, 3);
            ray = (struct rmap_ray){.origin = low};
            ray.direction = rmap_normalize(rmap_sub(top, low));
            expect_chain(&b, ray, AIR, mesh ? up_mesh : up_flat, 3);
        }
        builder_destroy(&b);
    }
}

static void test_cemented_spheres(void **state)
{
    (void)state;
    struct builder b;
    builder_open(&b, 8);
    struct rmap_shape cap = {.type = RMAP_SHAPE_CONIC, .curvature = -1 / 40.0, .aperture = 10};
    struct rmap_shape front = {.type = RMAP_SHAPE_CONIC, .curvature = 1 / 60.0, .aperture = 10};
    int32_t glued = builder_shape(&b, cap), first = builder_shape(&b, front);
    builder_object(&b, first, at(0, 0, 0), GLASS, AIR);
    builder_object(&b, glued, at(0, 0, 8.75), AIR, GLASS);
    builder_object(&b, glued, at(0, 0, 8.75), WATER, AIR);
    builder_object(&b, first, at(0, 0, 12), AIR, WATER);
    builder_close(&b);
    static const int32_t forward[] = {0, 1, 2, 3}, backward[] = {3, 2, 1, 0};
    for (uint64_t i = 0; i < 20000; i++) {
        double u[4];
        rmap_rng(9, i, 0, RMAP_RNG_EMIT_POINT, u);
        struct rmap_vec3 low = rmap_vec3(12 * (u[0] - 0.5), 12 * (u[1] - 0.5), -20);
        struct rmap_vec3 high = rmap_vec3(12 * (u[2] - 0.5), 12 * (u[3] - 0.5), 40);
        if (i % 5 == 0)
            low.x = low.y = high.x = high.y = 0;
        struct rmap_ray ray = {.origin = low, .direction = rmap_normalize(rmap_sub(high, low))};
        expect_chain(&b, ray, AIR, forward, 4);
        ray = (struct rmap_ray){.origin = high, .direction = rmap_normalize(rmap_sub(low, high))};
        expect_chain(&b, ray, AIR, backward, 4);
    }
    builder_destroy(&b);
}

/* Light that starts on a surface: a lamp lying on a ceiling shines away from it; a start on an
 * interface enters or not as its medium says. */
static void test_starts_on_surfaces(void **state)
{
    (void)state;
    struct builder b;
    builder_open(&b, 4);
    int32_t cube = builder_mesh(&b, make_cube(1));
    builder_object(&b, cube, at(0, 0, 0), AIR, GLASS);
    struct rmap_shape plate = {.type = RMAP_SHAPE_RECTANGLE, .size = {9, 9}};
    builder_object(&b, builder_shape(&b, plate), at(0, 0, 5), RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
    builder_close(&b);
    struct rmap_hit hit;
    struct rmap_ray lamp = {.origin = {0.3, 0.2, 5}, .direction = {0, 0, -1}, .medium = AIR};
    assert_true(rmap_accel_next(b.accel, &lamp, &hit));
    assert_int_equal(hit.object, 0);
    assert_true(fabs(hit.t - 4) < 1e-12);
    struct rmap_ray outside = {.origin = {0.3, 0.2, 1}, .direction = {0, 0, -1}, .medium = AIR};
    assert_true(rmap_accel_next(b.accel, &outside, &hit));
    assert_true(hit.t == 0 && hit.normal.z > 0);
    struct rmap_ray inside = outside;
    inside.medium = GLASS;
    assert_true(rmap_accel_next(b.accel, &inside, &hit));
    assert_true(fabs(hit.t - 2) < 1e-12 && hit.normal.z < 0);
    builder_destroy(&b);
}

/* Diffuse bounces inside a closed body; every fourth is aimed at an edge or a vertex. */
static int bounce(const struct builder *b, const struct rmap_mesh *mesh,
                  const struct rmap_affine *place, int n_ray, int n_bounce)
{
    int lost = 0;
    for (int r = 0; r < n_ray; r++) {
        struct rmap_ray ray = {.origin = place->t, .medium = AIR};
        ray.direction = any_direction((uint64_t)r, 0);
        for (int i = 1; i <= n_bounce; i++) {
            struct rmap_hit hit;
            if (!rmap_accel_next(b->accel, &ray, &hit) ||
                rmap_dot(hit.normal, ray.direction) <= 0) {
                lost++;
                break;
            }
            rmap_contact_turn(&ray.contact, &hit);
            ray.origin = hit.position;
            double u[4];
            rmap_rng(11, (uint64_t)r, (uint32_t)i, RMAP_RNG_SURFACE, u);
            ray.direction = rmap_normalize(
                rmap_axpy(-1.0001, hit.normal, any_direction((uint64_t)r, (uint32_t)i)));
            if (i % 4)
                continue;
            struct rmap_vec3 corner[3];
            rmap_mesh_corners(mesh, (size_t)(u[0] * (double)mesh->n_triangle), corner);
            struct rmap_vec3 to =
                rmap_axpy(i % 8 ? u[1] : 0, rmap_sub(corner[1], corner[0]), corner[0]);
            to = rmap_sub(rmap_affine_point(place, to), ray.origin);
            if (rmap_dot(to, hit.normal) < -1e-3 * rmap_length(to))
                ray.direction = rmap_normalize(to);
        }
    }
    return lost;
}

static void test_diffuse_light_stays_inside(void **state)
{
    (void)state;
    const struct rmap_affine places[] = {
        rmap_affine_identity(),
        rmap_affine_placement(rmap_vec3(-300, 500, 200), rmap_vec3(13, 29, 31),
                              rmap_vec3(100, 50, 20)),
        rmap_affine_placement(rmap_vec3(0.01, 0.01, 0.01), rmap_vec3(5, 6, 7),
                              rmap_vec3(1e5, 2e4, -1e5))};
    for (size_t k = 0; k < sizeof(places) / sizeof(places[0]); k++)
        for (int ball = 0; ball < 2; ball++) {
            struct builder b;
            builder_open(&b, 2);
            struct rmap_mesh *mesh = ball ? make_ball(10) : make_cube(1);
            builder_object(&b, builder_mesh(&b, mesh), places[k], RMAP_MEDIUM_ANY, AIR);
            struct rmap_shape dot = {.type = RMAP_SHAPE_DISC, .aperture = 1e-4};
            builder_object(&b, builder_shape(&b, dot), at(-900, 0, 0), AIR, AIR);
            builder_close(&b);
            int lost = bounce(&b, mesh, &places[k], 170, 1000);
            if (lost)
                fail_msg("place %zu, %s: %d of 170 rays lost", k, ball ? "ball" : "cube", lost);
            builder_destroy(&b);
        }
}

/* A room of six separate boxes whose corners overlap: light in its corners meets both walls. */
static void test_a_room_of_walls_is_closed(void **state)
{
    (void)state;
    struct builder b;
    builder_open(&b, 8);
    int32_t cube = builder_mesh(&b, make_cube(0.7));
    struct rmap_affine place =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(10, 20, 30), rmap_vec3(0.1, 0.2, 0.3));
    for (int k = 0; k < 6; k++) {
        double s = k % 2 ? 1 : -1, wide = 1.2 / 0.7, thin = 0.1 / 0.7;
        struct rmap_vec3 size =
            rmap_vec3(k / 2 == 0 ? thin : wide, k / 2 == 1 ? thin : wide, k / 2 == 2 ? thin : wide);
        struct rmap_vec3 where =
            rmap_vec3(k / 2 == 0 ? 1.1 * s : 0, k / 2 == 1 ? 1.1 * s : 0, k / 2 == 2 ? 1.1 * s : 0);
        struct rmap_affine wall = rmap_affine_placement(size, rmap_vec3(0, 0, 0), where);
        builder_object(&b, cube, rmap_affine_compose(&place, &wall), AIR, RMAP_MEDIUM_ANY);
    }
    builder_close(&b);
    struct rmap_mesh *inner = make_cube(1); /* edges and corners to aim at */
    int lost = 0;
    for (uint64_t r = 0; r < 300; r++) {
        struct rmap_ray ray = {.origin = place.t, .direction = any_direction(r, 0)};
        for (uint32_t i = 1; i <= 1000 && ray.medium == AIR; i++) {
            struct rmap_hit hit;
            if (!rmap_accel_next(b.accel, &ray, &hit) || rmap_dot(hit.normal, ray.direction) >= 0) {
                lost++;
                break;
            }
            rmap_contact_turn(&ray.contact, &hit);
            ray.origin = hit.position;
            ray.direction = rmap_normalize(rmap_axpy(1.0001, hit.normal, any_direction(r, i)));
            double u[4];
            rmap_rng(14, r, i, RMAP_RNG_SURFACE, u);
            struct rmap_vec3 c[3];
            rmap_mesh_corners(inner, (size_t)(12 * u[0]), c);
            struct rmap_vec3 to = rmap_axpy(i % 3 ? u[1] : 0, rmap_sub(c[1], c[0]), c[0]);
            to = rmap_sub(rmap_affine_point(&place, to), ray.origin);
            struct rmap_vec3 along = rmap_affine_transposed(&place, to);
            if (fmin(fabs(along.x), fmin(fabs(along.y), fabs(along.z))) < 1e-6)
                continue; /* in a wall's plane to rounding: on which side of it is a toss-up */
            if (i % 2 && rmap_dot(to, hit.normal) > 1e-3 * rmap_length(to))
                ray.direction = rmap_normalize(to);
        }
    }
    rmap_mesh_destroy(inner);
    builder_destroy(&b);
    if (lost)
        fail_msg("%d of 300 rays lost", lost);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_touching_boxes_are_crossed_once_each),
        cmocka_unit_test(test_edges_of_touching_boxes),
        cmocka_unit_test(test_reflections_at_touching_faces),
        cmocka_unit_test(test_discs_on_faces),
        cmocka_unit_test(test_cemented_spheres),
        cmocka_unit_test(test_starts_on_surfaces),
        cmocka_unit_test(test_a_room_of_walls_is_closed),
        cmocka_unit_test(test_diffuse_light_stays_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
