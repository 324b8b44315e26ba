/* SPDX-License-Identifier: MIT
 *
 * Prisms are closed, wound outward and have no flat triangle, whatever their polygon.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "geometry/prism.h"
#include "tests/unit/near.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* Every edge is passed once in each direction. */
static void check_closed(const struct rmap_mesh *mesh)
{
    const uint32_t(*triangle)[3] = (const uint32_t(*)[3])mesh->triangle;
    for (size_t t = 0; t < mesh->n_triangle; t++)
        for (int k = 0; k < 3; k++) {
            int with = 0, against = 0;
            uint32_t a = triangle[t][k], b = triangle[t][(k + 1) % 3];
            for (size_t u = 0; u < mesh->n_triangle; u++)
                for (int j = 0; j < 3; j++) {
                    with += triangle[u][j] == a && triangle[u][(j + 1) % 3] == b;
                    against += triangle[u][j] == b && triangle[u][(j + 1) % 3] == a;
                }
            assert_int_equal(with, 1);
            assert_int_equal(against, 1);
        }
}

/* Positive when triangles are wound outward. */
static double volume_of(const struct rmap_mesh *mesh)
{
    double volume = 0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 p[3];
        rmap_mesh_corners(mesh, t, p);
        struct rmap_vec3 normal = rmap_cross(rmap_sub(p[1], p[0]), rmap_sub(p[2], p[0]));
        assert_true(rmap_dot(normal, normal) > 0);
        volume += rmap_dot(p[0], normal) / 6;
    }
    return volume;
}

static void check_prism(const double (*corner)[2], size_t n, double area)
{
    struct rmap_error err = {0};
    struct rmap_mesh *mesh = NULL;
    if (rmap_mesh_prism(corner, n, 2, &mesh, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    assert_int_equal(mesh->n_face, n + 2);
    check_closed(mesh);
    assert_near(volume_of(mesh), 2 * area, 1e-12);
    /* Side k stands on corners k and k + 1. */
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 p[3];
        rmap_mesh_corners(mesh, t, p);
        for (int v = 0; v < 3 && mesh->face[t] >= 2; v++) {
            const double *a = corner[mesh->face[t] - 2], *b = corner[(mesh->face[t] - 1) % n];
            assert_true((p[v].x == a[0] && p[v].y == a[1]) || (p[v].x == b[0] && p[v].y == b[1]));
        }
        for (int v = 0; v < 3 && mesh->face[t] < 2; v++)
            assert_near(p[v].z, mesh->face[t] ? 2 : 0, 0);
    }
    rmap_mesh_destroy(mesh);
}

static void test_polygons(void **state)
{
    static const double square[][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    static const double clockwise[][2] = {{0, 4}, {4, 4}, {4, 0}, {0, 0}};
    static const double between[][2] = {{0, 0}, {1, 0}, {2, 0}, {4, 0}, {4, 4}, {2, 4}, {0, 4}};
    static const double ell[][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    static const double comb[][2] = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                                     {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    (void)state;
    check_prism(square, COUNT(square), 16);
    check_prism(clockwise, COUNT(clockwise), 16);
    check_prism(between, COUNT(between), 16);
    check_prism(ell, COUNT(ell), 3);
    check_prism(comb, COUNT(comb), 11);
}

static void test_bad_polygons(void **state)
{
    static const double bow[][2] = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};
    static const double twice[][2] = {{0, 0}, {4, 0}, {4, 0}, {0, 4}};
    static const double spike[][2] = {{0, 0}, {4, 0}, {2, 0}, {2, 4}};
    static const double flat[][2] = {{0, 0}, {1, 1}, {2, 2}};
    static const double touches[][2] = {{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}};
    static const double huge[][2] = {{0, 0}, {1e39, 0}, {0, 1}};
    static const struct {
        const double (*corner)[2];
        size_t n;
        const char *told;
    } bad[] = {{bow, 4, "sides 1 and 3 of the polygon cross or touch"},
               {twice, 4, "points 2 and 3 of the polygon are the same"},
               {spike, 4, "turns back on itself at point 2"},
               {flat, 3, "turns back on itself"},
               {touches, 5, "sides 1 and 3 of the polygon cross or touch"},
               {huge, 3, "1e30 at most"}};
    (void)state;
    for (size_t i = 0; i < COUNT(bad); i++) {
        struct rmap_error err = {0};
        struct rmap_mesh *mesh = NULL;
        assert_int_equal(rmap_mesh_prism(bad[i].corner, bad[i].n, 2, &mesh, &err), RMAP_INPUT);
        if (!strstr(err.text, bad[i].told))
            fail_msg("'%s' does not say '%s'", err.text, bad[i].told);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_polygons),
                                       cmocka_unit_test(test_bad_polygons)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
