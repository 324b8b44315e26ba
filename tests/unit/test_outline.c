/* SPDX-License-Identifier: MIT
 *
 * Drawings are true to scale: tessellated surfaces face the right way and have the right size,
 * their sections are whole curves that lie on the surface.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/figure/figure_outline.h"
#include "analysis/figure/tessellation.h"
#include "base/alloc.h"

/* Looking along -x at the plane x = 0: z to the right, y upwards. */
static const struct rmap_view yz = {
    .section = true, .right = {0, 0, 1}, .up = {0, 1, 0}, .toward = {-1, 0, 0}};

/* Area, and the flux of the field `r` through the mesh (3 x volume for a closed one). */
static void measure(const struct rmap_mesh *mesh, double *area, double *flux)
{
    *area = *flux = 0.0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 c[3];
        rmap_mesh_corners(mesh, t, c);
        struct rmap_vec3 n =
            rmap_scale(rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0])), 0.5);
        assert_true(rmap_length(n) > 0.0);
        *area += rmap_length(n);
        *flux += rmap_dot(n, c[0]);
    }
}

static void surfaces_have_their_size_and_side(void **state)
{
    (void)state;
    const struct {
        struct rmap_shape shape;
        double area, flux;
    } expected[] = {
        {{.type = RMAP_SHAPE_SPHERE, .radius = 2}, 16 * RMAP_PI, 32 * RMAP_PI},
        {{.type = RMAP_SHAPE_TUBE, .radius = 2, .radius2 = 2, .length = 5},
         20 * RMAP_PI,
         40 * RMAP_PI},
        {{.type = RMAP_SHAPE_RECTANGLE, .size = {3, 4}}, 12, 0},
        {{.type = RMAP_SHAPE_DISC, .aperture = 3, .inner = 1}, 8 * RMAP_PI, 0},
        /* Half a sphere about (0, 0, 2): its normal points to the centre. */
        {{.type = RMAP_SHAPE_CONIC, .curvature = 0.5, .aperture = 2}, 8 * RMAP_PI, -8 * RMAP_PI},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        struct rmap_mesh *mesh = NULL;
        double area, flux;
        assert_int_equal(rmap_shape_tessellate(&expected[i].shape, &mesh, NULL), RMAP_OK);
        measure(mesh, &area, &flux);
        if (fabs(area / expected[i].area - 1.0) > 0.01 ||
            fabs(flux - expected[i].flux) > 0.02 * expected[i].area)
            fail_msg("shape %zu: area %g, flux %g", i, area, flux);
        rmap_mesh_destroy(mesh);
    }
}

static void section_of_a_sphere_is_a_circle(void **state)
{
    (void)state;
    struct rmap_shape shape = {.type = RMAP_SHAPE_SPHERE, .radius = 5};
    struct rmap_affine place =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(20, 30, 40), rmap_vec3(3, 10, 20));
    struct rmap_mesh *mesh = NULL;
    struct rmap_outline outline = {0};
    assert_int_equal(rmap_shape_tessellate(&shape, &mesh, NULL), RMAP_OK);
    assert_int_equal(rmap_outline_cut(&outline, mesh, &place, &yz, NULL), RMAP_OK);
    assert_int_equal(outline.n_run, 1);
    assert_true(outline.run[0].closed);
    for (size_t i = 0; i < outline.n_point; i++) {
        double r = hypot(outline.point[i][0] - 20, outline.point[i][1] - 10);
        assert_true(fabs(r - 4.0) < 0.03); /* sqrt(25 - 9), less the facets' sag */
    }
    rmap_outline_fini(&outline);
    rmap_mesh_destroy(mesh);
}

/* Through the axis the profile is the sag itself, not that of facets. */
static void section_of_a_cap_is_its_sag(void **state)
{
    (void)state;
    struct rmap_shape shape = {.type = RMAP_SHAPE_CONIC,
                               .curvature = 0.02,
                               .conic = -0.7,
                               .asphere = {0, 1e-6},
                               .n_asphere = 2,
                               .aperture = 20};
    struct rmap_affine place = rmap_affine_identity();
    struct rmap_mesh *mesh = NULL;
    struct rmap_outline outline = {0};
    assert_int_equal(rmap_shape_tessellate(&shape, &mesh, NULL), RMAP_OK);
    assert_int_equal(rmap_outline_cut(&outline, mesh, &place, &yz, NULL), RMAP_OK);
    assert_int_equal(outline.n_run, 1);
    assert_false(outline.run[0].closed);
    for (size_t i = 0; i < outline.n_point; i++) {
        double r = fabs(outline.point[i][1]);
        assert_true(fabs(outline.point[i][0] - rmap_shape_sag(&shape, fmin(r, 20))) < 1e-5);
    }
    const double *first = outline.point[0], *last = outline.point[outline.n_point - 1];
    assert_true(fabs(fabs(first[1] - last[1]) - 40.0) < 1e-5);
    rmap_outline_fini(&outline);
    rmap_mesh_destroy(mesh);
}

/* A cube as files have it, three corners of its own per triangle: welded, its cut is one square. */
static void soup_is_welded(void **state)
{
    (void)state;
    static const uint8_t face[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                        {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                        {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    struct rmap_mesh *soup = NULL, *mesh = NULL;
    struct rmap_outline outline = {0};
    struct rmap_affine place = rmap_affine_identity();
    place.t = rmap_vec3(-0.3, 0, 0);
    assert_int_equal(rmap_mesh_create(36, 12, 1, &soup, NULL), RMAP_OK);
    for (size_t i = 0; i < 36; i++) {
        uint8_t corner = face[i / 3][i % 3];
        for (size_t k = 0; k < 3; k++)
            soup->vertex[i][k] = (float)(corner >> k & 1);
        soup->triangle[i / 3][i % 3] = (uint32_t)i;
    }
    assert_int_equal(rmap_mesh_weld(soup, &mesh, NULL), RMAP_OK);
    assert_int_equal(rmap_outline_cut(&outline, mesh, &place, &yz, NULL), RMAP_OK);
    assert_int_equal(outline.n_run, 1);
    assert_true(outline.run[0].closed);
    double length = 0.0;
    for (size_t i = 1; i < outline.n_point; i++)
        length += hypot(outline.point[i][0] - outline.point[i - 1][0],
                        outline.point[i][1] - outline.point[i - 1][1]);
    assert_true(fabs(length - 4.0) < 1e-6);
    rmap_outline_fini(&outline);
    rmap_mesh_destroy(mesh);
    rmap_mesh_destroy(soup);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_have_their_size_and_side),
        cmocka_unit_test(section_of_a_sphere_is_a_circle),
        cmocka_unit_test(section_of_a_cap_is_its_sag),
        cmocka_unit_test(soup_is_welded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
