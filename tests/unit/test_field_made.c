/* SPDX-License-Identifier: MIT
 *
 * Atmospheres, profiles, fields made of fields and indices over scalar fields.
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
#include "gradient/field_made.h"
#include "gradient/field_polynomial.h"
#include "gradient/models.h"
#include "optics/fluid.h"

static struct rmap_error err;
static const double line_nm[1] = {589.26};

static void none_left(struct rmap_field *field)
{
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void exponential(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_exponential road = {1.00027, -3e-5, 0.05, 0.0};
    assert_int_equal(rmap_field_exponential(&field, 1, &road, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(5, 6, 0.05)), 1.00027 - 3e-5 * exp(-1), 1e-16);
    field_check(field, 0, rmap_vec3(0.1, 0.2, 0.03), 1e-3, 1e-3);
    rmap_field_destroy(field);

    const struct rmap_exponential shell = {1.0, 2.8e-4, 0.8, 3.0};
    assert_int_equal(rmap_field_exponential(&field, 1, &shell, &err), RMAP_OK);
    field_check(field, 0, rmap_vec3(1.9, -2.0, 1.5), 1e-2, 1e-3);
    rmap_field_destroy(field);

    /* The Earth in metres: n - 1 to 1e-12 of itself, and its slope. */
    const struct rmap_exponential air = {1.0, 2.8e-4, 8000.0, 6371000.0};
    assert_int_equal(rmap_field_exponential(&field, 1, &air, &err), RMAP_OK);
    double n, h = 1234.5;
    struct rmap_vec3 gradient;
    const struct rmap_vec3 up = {0.48, 0.6, 0.64};
    assert_true(rmap_field_at(field, 0, rmap_scale(up, 6371000.0 + h), &n, &gradient));
    assert_near(n - 1.0, 2.8e-4 * exp(-h / 8000.0), 1e-12 * 2.8e-4 + 2.3e-16);
    assert_near(rmap_dot(gradient, up), -3.5e-8 * exp(-h / 8000.0), 1e-12 * 3.5e-8);
    none_left(field);
    const struct rmap_exponential two[2] = {{1.0, 2.8e-4, 8000.0, 6371000.0},
                                            {1.0, 2.7e-4, 8000.0, 0.0}};
    assert_int_equal(rmap_field_exponential(&field, 2, two, &err), RMAP_INPUT);
}

/* U.S. Standard Atmosphere 1976, table I: density over that at sea level at geometric heights. */
static void standard_air(void **state)
{
    (void)state;
    static const struct {
        double height_m, density;
    } row[] = {{0, 1.2250},        {5000, 7.3643e-1},  {10000, 4.1351e-1}, {15000, 1.9476e-1},
               {20000, 8.8910e-2}, {30000, 1.8410e-2}, {50000, 1.0269e-3}, {80000, 1.8458e-5}};
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++)
        assert_near(rmap_standard_density(row[i].height_m, 0.0), row[i].density / 1.2250,
                    6e-5 * row[i].density);

    struct rmap_field *field = NULL;
    struct rmap_standard_air parameter = {6371e6, 1000.0, 288.15, 101325.0};
    assert_int_equal(rmap_field_standard_air(&field, 1, line_nm, &parameter, &err), RMAP_OK);
    /* air at 0 C and the sodium lines: 1.000293 (Hecht, Optics, table 3.2) */
    double refractivity = rmap_air_refractivity(589.26);
    assert_near(refractivity * 288.15 / 273.15, 2.93e-4, 1e-6);
    for (size_t i = 0; i + 2 < sizeof row / sizeof row[0]; i++) {
        double n = field_value(field, 0, rmap_vec3(0, 6371e6 + 1000.0 * row[i].height_m, 0));
        assert_near((n - 1.0) / refractivity, row[i].density / 1.2250, 1e-4 * row[i].density);
    }
    /* Between knots the spline holds the law, away from the kinks at 11, 20, ... km. */
    double n = field_value(field, 0, rmap_vec3(0, 0, -6371e6 - 4.05e6));
    assert_near((n - 1.0) / refractivity, rmap_standard_density(4050.0, 0.0), 1e-10);
    assert_true(field_value(field, 0, rmap_vec3(0, 0, 6371e6 + 400e6)) >= 1.0);
    rmap_field_destroy(field);

    parameter = (struct rmap_standard_air){0.0, 1.0, 303.15, 99000.0};
    assert_int_equal(rmap_field_standard_air(&field, 1, line_nm, &parameter, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(7, 8, 0)) - 1.0,
                refractivity * 288.15 / 303.15 * 99000.0 / 101325.0, 1e-15);
    field_check(field, 0, rmap_vec3(0, 0, 3030.0), 50.0, 1e-7);
    double laplacian;
    assert_true(rmap_field_laplacian(field, 0, rmap_vec3(0, 0, -500.0), &laplacian));
    parameter.temperature_k = 100.0;
    rmap_field_destroy(field);
    assert_int_equal(rmap_field_standard_air(&field, 1, line_nm, &parameter, &err), RMAP_INPUT);
    parameter.temperature_k = 288.15;
    assert_int_equal(rmap_field_standard_air(&field, 1, (const double[]){150.0}, &parameter, &err),
                     RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* A spline repeats a cubic whose ends are natural or even: 3 s^2 - s^3 has both on [0, 1]. */
static void profile(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    double at[6], n[6];
    for (int i = 0; i < 6; i++) {
        at[i] = 0.04 * i * i;
        n[i] = 1.5 + 0.1 * (3.0 * at[i] * at[i] - at[i] * at[i] * at[i]);
    }
    assert_int_equal(rmap_field_profile(&field, RMAP_PROFILE_RHO, 0.0, 1, 6, at, n, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_vec3(0.3, 0.4, 2)), 1.5 + 0.1 * (0.75 - 0.125), 1e-15);
    field_check(field, 0, rmap_vec3(0.3, -0.35, 0.2), 1e-3, 1.0);
    assert_near(field_value(field, 0, rmap_vec3(0, 1.5, 0)), 1.5 + 0.1 * (2.0 + 3.0 * 0.5), 1e-14);
    double laplacian;
    assert_true(rmap_field_laplacian(field, 0, rmap_vec3(0, 0, 1), &laplacian));
    assert_near(laplacian, 2.0 * 0.6, 1e-11);
    rmap_field_destroy(field);
    for (int s = RMAP_PROFILE_Z; s <= RMAP_PROFILE_R; s++) {
        double radius = s == RMAP_PROFILE_R ? 0.2 : 0.0;
        assert_int_equal(
            rmap_field_profile(&field, (enum rmap_profile_variable)s, radius, 1, 6, at, n, &err),
            RMAP_OK);
        field_check(field, 0, rmap_vec3(0.2, -0.25, 0.26), 1e-3, 1.0);
        rmap_field_destroy(field);
    }
    at[3] = at[2];
    assert_int_equal(rmap_field_profile(&field, RMAP_PROFILE_Z, 0.0, 1, 6, at, n, &err),
                     RMAP_INPUT);
    assert_non_null(strstr(err.text, "increasing"));
    assert_int_equal(rmap_field_profile(&field, RMAP_PROFILE_Z, 0.0, 1, 1, at, n, &err),
                     RMAP_INPUT);
    at[0] = -0.1;
    assert_int_equal(rmap_field_profile(&field, RMAP_PROFILE_RHO, 0.0, 1, 3, at, n, &err),
                     RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

static struct rmap_field *series_of(enum rmap_series_variable s, double a, double b, double c)
{
    struct rmap_field *field = NULL;
    const double coefficient[3] = {a, b, c};
    assert_int_equal(rmap_field_series(&field, s, RMAP_SERIES_OF_N, 1, 3, coefficient, &err),
                     RMAP_OK);
    return field;
}

static void sum(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    struct rmap_field *term[2] = {series_of(RMAP_SERIES_Z, 1.001, 0.01, 0.0),
                                  series_of(RMAP_SERIES_R2, 0.9, 0.05, 0.01)};
    const double weight[2] = {1.0, 2.0};
    assert_int_equal(rmap_field_sum(&field, 1.0, 2, term, weight, &err), RMAP_OK);
    const struct rmap_vec3 p = {0.1, 0.2, 0.3};
    assert_near(field_value(field, 0, p),
                1.0 + (0.001 + 0.003) + 2.0 * (-0.1 + 0.05 * 0.14 + 0.01 * 0.0196), 1e-15);
    field_check_within(field, 0, 1.0);
    none_left(field);
    /* Terms are taken also by a sum that fails. */
    term[0] = series_of(RMAP_SERIES_Z, 1.0, 0.0, 0.0);
    const double bad[1] = {(double)NAN};
    assert_int_equal(rmap_field_sum(&field, 1.0, 1, term, bad, &err), RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Two channels on top of a model that has one, and a frame inside a frame. */
static void dispersed_and_placed(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const struct rmap_dispersed parameter[2] = {{1.0, 0.01}, {0.9, 0.0}};
    assert_int_equal(rmap_field_dispersed(&field, series_of(RMAP_SERIES_RHO2, 1.5, -0.1, 0.02), 2,
                                          parameter, &err),
                     RMAP_OK);
    assert_int_equal(field->n_channel, 2);
    assert_near(field_value(field, 0, rmap_vec3(1, 0, 0)), 1.43, 1e-15);
    assert_near(field_value(field, 1, rmap_vec3(1, 0, 0)), 1.0 + 0.9 * 0.42, 1e-15);
    field_check_within(field, 1, 1.0);
    const struct rmap_affine to_world =
        rmap_affine_placement(rmap_vec3(2, 1, 3), rmap_vec3(10, 20, 30), rmap_vec3(1, 2, 3));
    struct rmap_affine to_local;
    assert_true(rmap_affine_invert(&to_world, &to_local));
    assert_int_equal(rmap_field_placed(&field, field, &to_local, &err), RMAP_OK);
    assert_near(field_value(field, 0, rmap_affine_point(&to_world, rmap_vec3(1, 0, 9))), 1.43,
                1e-14);
    field_check(field, 1, rmap_vec3(1.3, 1.8, 2.9), 2e-3, 1.0);
    none_left(field);
    const struct rmap_dispersed zero = {0.0, 0.0};
    assert_int_equal(
        rmap_field_dispersed(&field, series_of(RMAP_SERIES_Z, 1.5, 0, 0), 1, &zero, &err),
        RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

static struct rmap_field *index_of(struct rmap_field *scalar, const struct rmap_index_of *law)
{
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_of_scalar(&field, scalar, 1, line_nm, law, &err), RMAP_OK);
    return field;
}

static void over_scalars(void **state)
{
    (void)state;
    const struct rmap_vec3 p = {0.3, 0.2, 0.5};
    /* temperature in Celsius, below zero at p: a scalar may be */
    struct rmap_field *field = index_of(
        series_of(RMAP_SERIES_Z, -20.0, 30.0, 0.0),
        &(struct rmap_index_of){.law = RMAP_INDEX_AIR, .pressure_pa = 101325, .zero_k = 273.15});
    assert_near(field_value(field, 0, p) - 1.0, rmap_air_refractivity(589.26) * 288.15 / 268.15,
                1e-15);
    field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);

    /* distilled water at 20 C and the sodium lines: 1.33299 (Quan & Fry 1995 fit the data of Austin
     * and Halikas 1976 to 1.5e-5) */
    field = index_of(
        series_of(RMAP_SERIES_Z, 0.0, 35.0, 1.0),
        &(struct rmap_index_of){.law = RMAP_INDEX_SEAWATER_SALINITY, .temperature_c = 20.0});
    assert_near(field_value(field, 0, rmap_vec3(0, 0, 0)), 1.33299, 3e-5);
    assert_near(field_value(field, 0, rmap_vec3(0, 0, 1)), 1.33299 + 36.0 * 1.85e-4, 2e-4);
    field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);
    field =
        index_of(series_of(RMAP_SERIES_R2, 15.0, 10.0, 1.0),
                 &(struct rmap_index_of){.law = RMAP_INDEX_SEAWATER_TEMPERATURE, .salinity = 35.0});
    field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);

    field = index_of(
        series_of(RMAP_SERIES_Z, 1.0, 0.5, 0.0),
        &(struct rmap_index_of){.law = RMAP_INDEX_GLADSTONE_DALE, .n0 = 1.0003, .reference = 1.25});
    assert_near(field_value(field, 0, p), 1.0003, 1e-15);
    rmap_field_destroy(field);
    field = index_of(series_of(RMAP_SERIES_Z, -1.0, 0.5, 0.0),
                     &(struct rmap_index_of){.law = RMAP_INDEX_LINEAR, .n0 = 1.5, .slope = 0.4});
    assert_near(field_value(field, 0, p), 1.2, 1e-15);
    rmap_field_destroy(field);
    const double at[4] = {-1.0, 0.0, 0.7, 2.0}, n[4] = {1.3, 1.4, 1.45, 1.6};
    field =
        index_of(series_of(RMAP_SERIES_R2, 0.0, 1.0, 0.5),
                 &(struct rmap_index_of){.law = RMAP_INDEX_TABLE, .n_point = 4, .at = at, .n = n});
    assert_near(field_value(field, 0, rmap_vec3(0, 0, 0)), 1.4, 1e-15);
    field_check(field, 0, rmap_vec3(0.4, 0.3, -0.2), 1e-3, 1.0);
    none_left(field);
    assert_int_equal(rmap_field_of_scalar(
                         &field, series_of(RMAP_SERIES_Z, 1, 1, 1), 1, line_nm,
                         &(struct rmap_index_of){.law = RMAP_INDEX_AIR, .pressure_pa = 0}, &err),
                     RMAP_INPUT);
    assert_non_null(strstr(err.text, "pressure"));
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(exponential),
                                       cmocka_unit_test(standard_air),
                                       cmocka_unit_test(profile),
                                       cmocka_unit_test(sum),
                                       cmocka_unit_test(dispersed_and_placed),
                                       cmocka_unit_test(over_scalars)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
