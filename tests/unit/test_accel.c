/* SPDX-License-Identifier: MIT
 *
 * Rays aimed at the edges and vertices of closed meshes, through instances of every kind: none
 * leaks.
 */
#include <math.h>

#include "build_scene.h"

enum { AIR = 0, GLASS = 1 };

/* Points to aim at: vertices, points on edges, points inside triangles. */
static struct rmap_vec3 aim(const struct rmap_mesh *mesh, uint64_t i)
{
    double u[4];
    rmap_rng(2, i, 0, RMAP_RNG_EMIT_POINT, u);
    struct rmap_vec3 c[3];
    rmap_mesh_corners(mesh, (size_t)(u[0] * (double)mesh->n_triangle), c);
    switch (i % 4) {
    case 0:
        return c[0];
    case 1:
        return rmap_scale(rmap_add(c[0], c[1]), 0.5);
    case 2:
        return rmap_axpy(u[1], rmap_sub(c[2], c[1]), c[1]);
    default:
        return rmap_scale(rmap_add(rmap_add(c[0], c[1]), c[2]), 1.0 / 3);
    }
}

/* Every direction, every third nearly in the plane of the triangle that is aimed at. */
static struct rmap_vec3 towards(const struct rmap_mesh *mesh, uint64_t i)
{
    struct rmap_vec3 d = any_direction(i, 0), c[3];
    double u[4];
    if (i % 3)
        return d;
    rmap_rng(2, i, 0, RMAP_RNG_EMIT_POINT, u);
    rmap_mesh_corners(mesh, (size_t)(u[0] * (double)mesh->n_triangle), c);
    struct rmap_vec3 n = rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0]));
    n = rmap_normalize(n);
    d = rmap_axpy(-rmap_dot(d, n), n, d);
    return rmap_normalize(rmap_axpy((u[3] < 0.5 ? -1 : 1) * pow(10, -7 * u[2]), n, d));
}

struct placement {
    const char *name;
    struct rmap_affine place;
};

static const struct placement placements[] = {
    {"identity", {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}}},
    {"mirrored", {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {3, 1, -2}}},
    {"turned", {{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}, {-2, 7, 1.5}}},
    {"sheared", {{{1, 0.7, 0.2}, {0, 1.3, -0.4}, {0.1, 0, 0.8}}, {0.3, 0.1, 0.7}}},
    {"uneven", {{{2, 0, 0}, {0, 0.1, 0}, {0, 0, 1}}, {1, 2, 3}}},
    {"small and far", {{{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}, {1e5, -1e5, 3e4}}},
    {"mirrored, small and far",
     {{{0.0036, 0.0048, 0.008}, {-0.008, 0.006, 0}, {0.0048, 0.0064, -0.006}}, {1e5, 3e4, -1e5}}},
};
enum { N_PLACEMENT = sizeof(placements) / sizeof(placements[0]) };

/* A scene with the mesh and, so that its centre is elsewhere, a far small disc. */
static void place_mesh(struct builder *b, struct rmap_mesh *mesh, const struct placement *p)
{
    builder_open(b, 2);
    builder_object(b, builder_mesh(b, mesh), p->place, AIR, GLASS);
    struct rmap_affine corner = rmap_affine_identity();
    corner.t = rmap_vec3(-5, -5, -5);
    builder_object(b,
                   builder_shape(b, (struct rmap_shape){.type = RMAP_SHAPE_DISC, .aperture = 1e-3}),
                   corner, AIR, AIR);
    builder_close(b);
}

static void check_inside_out(const struct builder *b, const struct rmap_mesh *mesh,
                             const struct placement *p, uint64_t n)
{
    int leaks = 0, wrong = 0;
    for (uint64_t i = 0; i < n; i++) {
        double u[4];
        rmap_rng(3, i, 0, RMAP_RNG_EMIT_POINT, u);
        struct rmap_vec3 from = rmap_vec3(0.3 * u[0], 0.3 * u[1] - 0.2, 0.3 * u[2] - 0.1);
        struct rmap_vec3 to = rmap_affine_point(&p->place, aim(mesh, i));
        struct rmap_ray ray = {.origin = rmap_affine_point(&p->place, from), .medium = GLASS};
        ray.direction = rmap_normalize(rmap_sub(to, ray.origin));
        struct rmap_hit hit;
        if (!rmap_accel_next(b->accel, &ray, &hit) || hit.object != 0) {
            leaks++;
            continue;
        }
        double scale = rmap_length(rmap_sub(to, ray.origin));
        double off = rmap_length(rmap_sub(hit.position, to));
        if (off > 1e-5 * scale || rmap_dot(hit.normal, ray.direction) <= 0)
            wrong++;
        rmap_contact_pass(&ray.contact, &hit);
        ray.origin = hit.position;
        ray.medium = AIR;
        if (rmap_accel_next(b->accel, &ray, &hit) && hit.object == 0)
            wrong++;
    }
    if (leaks || wrong)
        fail_msg("%s: %d leaks, %d wrong of %d", p->name, leaks, wrong, (int)n);
}

/* From outside a body is entered and left in turn: a convex one at most once. */
static void check_outside_in(const struct builder *b, const struct rmap_mesh *mesh,
                             const struct placement *p, uint64_t n, int most)
{
    int wrong = 0, met = 0;
    for (uint64_t i = 0; i < n; i++) {
        struct rmap_vec3 to = aim(mesh, i);
        struct rmap_vec3 d = towards(mesh, i);
        double u[4];
        rmap_rng(4, i, 0, RMAP_RNG_EMIT_POINT, u);
        struct rmap_vec3 from = rmap_axpy(-(4 + 20 * u[0]), d, to);
        struct rmap_ray ray = {.origin = rmap_affine_point(&p->place, from), .medium = AIR};
        ray.direction = rmap_normalize(rmap_sub(rmap_affine_point(&p->place, to), ray.origin));
        struct rmap_hit hit;
        int crossings = 0;
        while (crossings < most + 2 && rmap_accel_next(b->accel, &ray, &hit)) {
            if (hit.object == 0) {
                bool entering = rmap_dot(hit.normal, ray.direction) < 0;
                if (entering != (ray.medium == AIR))
                    wrong++;
                ray.medium = entering ? GLASS : AIR;
                crossings++;
            }
            rmap_contact_pass(&ray.contact, &hit);
            ray.origin = hit.position;
        }
        met += crossings > 0;
        if (crossings % 2 || crossings > most)
            wrong++;
    }
    if (wrong)
        fail_msg("%s: %d wrong of %d, %d met it", p->name, wrong, (int)n, met);
    assert_true(met > (int)n / 2);
}

static void check_all(struct rmap_mesh *(*make)(void), uint64_t n, int most)
{
    for (int k = 0; k < N_PLACEMENT; k++) {
        struct builder b;
        struct rmap_mesh *mesh = make();
        place_mesh(&b, mesh, &placements[k]);
        if (most == 2)
            check_inside_out(&b, mesh, &placements[k], n);
        check_outside_in(&b, mesh, &placements[k], n, most);
        builder_destroy(&b);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

static struct rmap_mesh *cube(void)
{
    return make_cube(1);
}

static struct rmap_mesh *ball(void)
{
    return make_ball(8);
}

/* A ball with a rough skin: edges and corners of every kind, convex, concave and saddle. */
static struct rmap_mesh *rough(void)
{
    struct rmap_mesh *mesh = make_ball(6);
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        double u[4];
        rmap_rng(5, i, 0, RMAP_RNG_EMIT_POINT, u);
        for (int k = 0; k < 3; k++)
            mesh->vertex[i][k] *= (float)(0.6 + 0.8 * u[0]);
    }
    return mesh;
}

static void test_a_rough_body_is_entered_and_left_in_turn(void **state)
{
    (void)state;
    check_all(rough, 50000, 40);
}

static void test_no_ray_leaks_from_a_cube(void **state)
{
    (void)state;
    check_all(cube, 50000, 2);
}

static void test_no_ray_leaks_from_a_ball(void **state)
{
    (void)state;
    check_all(ball, 50000, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_ray_leaks_from_a_cube),
        cmocka_unit_test(test_no_ray_leaks_from_a_ball),
        cmocka_unit_test(test_a_rough_body_is_entered_and_left_in_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
