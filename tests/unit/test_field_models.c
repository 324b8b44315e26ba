/* SPDX-License-Identifier: MIT
 *
 * The classic index fields: known values, gradients and Laplacians against differences, places
 * without a value, parameters refused by name.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "field_check.h"
#include "gradient/field_polynomial.h"
#include "gradient/gradient.h"
#include "gradient/models.h"

static struct rmap_error err;

static bool has_index(const struct rmap_field *field, double x, double y, double z)
{
    double n;
    struct rmap_vec3 gradient;
    return rmap_field_at(field, 0, rmap_vec3(x, y, z), &n, &gradient);
}

static void done(struct rmap_field *field)
{
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void luneburg(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_luneburg parameter = {1.0, 2.0};
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, &err), RMAP_OK);
    assert_string_equal(field->ops->model, "luneburg");
    assert_near(field_value(field, 0, rmap_vec3(0, 0, 0)), sqrt(2.0), 1e-15);
    assert_near(field_value(field, 0, rmap_vec3(1.2, -1.6, 0)), 1.0, 1e-15);
    field_check_within(field, 0, 2.0);
    field_check(field, 0, rmap_vec3(0, 0, 0), 1e-3, 1.0);
    assert_true(has_index(field, 2.8, 0, 0));
    assert_false(has_index(field, 2.9, 0, 0));
    /* D = n grad n = -p / radius^2: light swings with the period 2 pi radius in t. */
    double n;
    struct rmap_vec3 gradient;
    assert_true(rmap_field_at(field, 0, rmap_vec3(0.3, 0.4, 0.5), &n, &gradient));
    assert_near(n * gradient.y, -0.1, 1e-15);
    assert_true(field->ops->best_step(field, rmap_vec3(0, 0, 0), rmap_vec3(1, 0, 0)) > 0.1);
    done(field);
}

static void maxwell(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_maxwell parameter = {2.0, 1.0};
    assert_int_equal(rmap_field_maxwell(&field, 1, &parameter, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(0.6, 0, 0.8)), 1.0, 1e-15);
    assert_near(field_value(field, 0, rmap_vec3(0.5, 0, 0)), 1.6, 1e-15);
    field_check_within(field, 0, 1.0);
    done(field);
}

static void eaton(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_eaton parameter = {1.0, 1.0};
    assert_int_equal(rmap_field_eaton(&field, 1, &parameter, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(0, 1, 0)), 1.0, 1e-15);
    assert_near(field_value(field, 0, rmap_vec3(0, 0, -0.2)), 3.0, 1e-15);
    field_check(field, 0, rmap_vec3(0.4, -0.3, 0.6), 1e-3, 1.0);
    field_check(field, 0, rmap_vec3(0.02, 0.03, 0.01), 2e-5, 1e4);
    assert_false(has_index(field, 0, 0, 0));
    assert_false(has_index(field, 2, 0, 0));
    assert_true(field->may_be_missing);
    done(field);
}

static void gutman(void **state)
{
    (void)state;
    struct rmap_field *field = NULL, *luneburg_field = NULL;
    const struct rmap_gutman parameter[2] = {{1.0, 1.0, 0.5}, {1.0, 1.0, 1.0}};
    const struct rmap_luneburg same = {1.0, 1.0};
    assert_int_equal(rmap_field_gutman(&field, 2, parameter, &err), RMAP_OK);
    assert_int_equal(rmap_field_luneburg(&luneburg_field, 1, &same, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(0, 0, 0)), sqrt(5.0), 1e-15);
    assert_near(field_value(field, 0, rmap_vec3(0, -1, 0)), 1.0, 1e-15);
    field_check_within(field, 0, 1.0);
    const struct rmap_vec3 p = {0.3, 0.1, -0.2};
    assert_near(field_value(field, 1, p), field_value(luneburg_field, 1, p), 0.0);
    rmap_field_destroy(luneburg_field);
    done(field);
}

static void rods(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_parabolic parabolic = {1.5, 0.1};
    assert_int_equal(rmap_field_parabolic(&field, 1, &parabolic, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(3, 4, 7)), 1.5 * sqrt(0.75), 1e-15);
    field_check_within(field, 0, 5.0);
    assert_false(has_index(field, 10, 0, 0));
    rmap_field_destroy(field);

    const struct rmap_selfoc selfoc = {1.608, 0.339 * 0.339};
    assert_int_equal(rmap_field_selfoc(&field, 1, &selfoc, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(0, 0.9, 1)),
                1.608 * (1.0 - 0.339 * 0.339 * 0.81 / 2), 1e-15);
    field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);

    const struct rmap_sech sech = {1.5, 0.1};
    assert_int_equal(rmap_field_sech(&field, 1, &sech, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(8, 0, 0)), 1.5 / cosh(0.8), 1e-15);
    field_check_within(field, 0, 8.0);
    /* both sides of where the series takes over: (alpha rho)^2 = 1e-3 */
    double below, above;
    assert_true(rmap_field_laplacian(field, 0, rmap_vec3(sqrt(0.0999), 0, 0), &below));
    assert_true(rmap_field_laplacian(field, 0, rmap_vec3(sqrt(0.1001), 0, 0), &above));
    assert_near(above, below, 2e-5 * fabs(below));
    assert_true(rmap_field_laplacian(field, 0, rmap_vec3(0, 0, 3), &above));
    assert_near(above, -2.0 * 1.5 * 0.01, 1e-16);
    done(field);
}

static void series(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const double spherical[3] = {1.6, -0.2, 0.05}, squared[2] = {2.25, 0.04};
    for (int s = RMAP_SERIES_Z; s <= RMAP_SERIES_R2; s++) {
        assert_int_equal(rmap_field_series(&field, (enum rmap_series_variable)s, RMAP_SERIES_OF_N,
                                           1, 3, spherical, &err),
                         RMAP_OK);
        field_check_within(field, 0, 1.0);
        rmap_field_destroy(field);
    }
    /* n^2 = n0^2 + 2 b z: D is constant, light flies parabolas */
    assert_int_equal(
        rmap_field_series(&field, RMAP_SERIES_Z, RMAP_SERIES_OF_N_SQUARED, 1, 2, squared, &err),
        RMAP_OK);
    field_check_within(field, 0, 4.0);
    double n;
    struct rmap_vec3 gradient;
    assert_true(rmap_field_at(field, 0, rmap_vec3(1, 2, 5), &n, &gradient));
    assert_near(n, sqrt(2.45), 1e-15);
    assert_near(n * gradient.z, 0.02, 1e-16);
    rmap_field_destroy(field);

    const double constant[2] = {1.5, 1.6};
    assert_int_equal(
        rmap_field_series(&field, RMAP_SERIES_R2, RMAP_SERIES_OF_N, 2, 1, constant, &err), RMAP_OK);
    assert_near(field_value(field, 1, rmap_vec3(1, 2, 3)), 1.6, 0.0);
    assert_true(isinf(field->ops->best_step(field, rmap_vec3(1, 2, 3), rmap_vec3(1, 0, 0))));
    done(field);
}

static void refused(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_luneburg no_radius = {1.0, 0.0}, no_number = {(double)NAN, 1.0};
    const struct rmap_selfoc endless = {1.5, (double)INFINITY};
    const double series_of[2] = {1.5, (double)NAN};
    assert_int_equal(rmap_field_luneburg(&field, 1, &no_radius, &err), RMAP_INPUT);
    assert_string_equal(err.text, "luneburg: radius is 0; give a number > 0");
    assert_int_equal(rmap_field_luneburg(&field, 1, &no_number, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "n_edge"));
    assert_int_equal(rmap_field_selfoc(&field, 1, &endless, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "selfoc: A"));
    assert_int_equal(
        rmap_field_series(&field, RMAP_SERIES_Z, RMAP_SERIES_OF_N, 1, 2, series_of, &err),
        RMAP_INPUT);
    assert_int_equal(
        rmap_field_series(&field, RMAP_SERIES_Z, RMAP_SERIES_OF_N, 1, 0, series_of, &err),
        RMAP_INPUT);
    const struct rmap_luneburg good = {1.0, 1.0};
    for (int call = 1; call <= 2; call++) {
        rmap_alloc_fail_at(call);
        assert_int_equal(rmap_field_luneburg(&field, 1, &good, &err), RMAP_SYSTEM);
    }
    rmap_alloc_fail_at(0);
    assert_null(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* A stretched, turned and moved body carries its index with it. */
static void in_place(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_luneburg parameter = {1.0, 1.0};
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, &err), RMAP_OK);
    struct rmap_gradient place = {.field = field};
    place.to_world =
        rmap_affine_placement(rmap_vec3(2, 3, 1), rmap_vec3(20, -30, 50), rmap_vec3(7, 8, -9));
    assert_true(rmap_affine_invert(&place.to_world, &place.to_local));
    struct rmap_vec3 p = rmap_affine_point(&place.to_world, rmap_vec3(0.1, -0.2, 0.4));
    double n, h = 1e-4;
    struct rmap_vec3 slope = {0.0, 0.0, 0.0};
    assert_true(rmap_gradient_at(&place, 0, p, &n, &slope));
    assert_near(n, sqrt(2.0 - 0.21), 1e-14);
    const struct rmap_vec3 along = {0.48, 0.6, 0.64};
    double ahead, behind;
    struct rmap_vec3 unused;
    assert_true(rmap_gradient_at(&place, 0, rmap_axpy(h, along, p), &ahead, &unused));
    assert_true(rmap_gradient_at(&place, 0, rmap_axpy(-h, along, p), &behind, &unused));
    assert_near(rmap_dot(slope, along), (ahead - behind) / (2 * h), 1e-8);
    p = rmap_affine_point(&place.to_world, rmap_vec3(1.5, 0, 0));
    assert_false(rmap_gradient_at(&place, 0, p, &n, &slope));
    done(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(luneburg), cmocka_unit_test(maxwell),
                                       cmocka_unit_test(eaton),    cmocka_unit_test(gutman),
                                       cmocka_unit_test(rods),     cmocka_unit_test(series),
                                       cmocka_unit_test(refused),  cmocka_unit_test(in_place)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
