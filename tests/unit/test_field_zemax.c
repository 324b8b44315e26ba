/* SPDX-License-Identifier: MIT
 *
 * The gradient surfaces of Zemax against their formulas written out, and polynomials.
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
#include "gradient/models.h"

static struct rmap_error err;
static const struct rmap_vec3 place = {0.3, -0.5, 0.7};

/* By the manual's names; the rest 0. */
struct said {
    const char *name;
    double value;
};

static struct rmap_field *zemax(int type, int n_channel, const double *wavelength_nm,
                                const struct said *said)
{
    double parameter[RMAP_ZEMAX_PARAMETER_MAX] = {0};
    struct rmap_field *field = NULL;
    for (; said->name; said++) {
        int i = 0;
        while (rmap_zemax_parameter(type, i) && strcmp(rmap_zemax_parameter(type, i), said->name))
            i++;
        assert_non_null(rmap_zemax_parameter(type, i));
        parameter[i] = said->value;
    }
    assert_int_equal(rmap_field_zemax(&field, type, n_channel, wavelength_nm, parameter, &err),
                     RMAP_OK);
    return field;
}

static void formula(int type, const struct said *said, double expected)
{
    struct rmap_field *field = zemax(type, 1, (const double[]){587.56}, said);
    assert_near(field_value(field, 0, place), expected, 1e-14);
    if (type == 1 || type == 10) /* with kinks on the axis */
        field_check(field, 0, place, 2e-3, 1.0);
    else
        field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void formulas(void **state)
{
    (void)state;
    double x = place.x, y = place.y, z = place.z, r2 = x * x + y * y;
    formula(1, (const struct said[]){{"n0", 1.6}, {"nr2", -0.1}, {"nr1", 0.02}, {NULL, 0}},
            1.6 - 0.1 * r2 + 0.02 * sqrt(r2));
    formula(2,
            (const struct said[]){
                {"n0", 2.5}, {"nr2", -0.1}, {"nr6", 0.03}, {"nr12", -0.01}, {NULL, 0}},
            sqrt(2.5 - 0.1 * r2 + 0.03 * pow(r2, 3) - 0.01 * pow(r2, 6)));
    formula(3,
            (const struct said[]){{"n0", 1.6},
                                  {"nr2", -0.1},
                                  {"nr4", 0.02},
                                  {"nr6", 0.03},
                                  {"nz1", 0.05},
                                  {"nz2", -0.04},
                                  {"nz3", 0.01},
                                  {NULL, 0}},
            1.6 - 0.1 * r2 + 0.02 * r2 * r2 + 0.03 * pow(r2, 3) + 0.05 * z - 0.04 * z * z +
                0.01 * pow(z, 3));
    formula(4,
            (const struct said[]){{"n0", 1.6},
                                  {"nx1", 0.01},
                                  {"nx2", 0.02},
                                  {"ny1", -0.03},
                                  {"ny2", 0.04},
                                  {"nz1", 0.05},
                                  {"nz2", -0.06},
                                  {NULL, 0}},
            1.6 + 0.01 * x + 0.02 * x * x - 0.03 * y + 0.04 * y * y + 0.05 * z - 0.06 * z * z);
    formula(
        5,
        (const struct said[]){
            {"n0", 1.6}, {"nr2", -0.1}, {"nr4", 0.02}, {"nz1", 0.05}, {"nz4", -0.04}, {NULL, 0}},
        1.6 - 0.1 * r2 + 0.02 * r2 * r2 + 0.05 * z - 0.04 * pow(z, 4));
    formula(10, (const struct said[]){{"n0", 1.6}, {"ny1", 0.1}, {"ny6", -0.2}, {NULL, 0}},
            1.6 + 0.1 * fabs(y) - 0.2 * pow(y, 6));
    formula(12,
            (const struct said[]){
                {"n0", 1.6}, {"cx1", 0.1}, {"cy3", -0.2}, {"cz20", 0.3}, {"cx5", 0.05}, {NULL, 0}},
            1.6 + 0.1 * x - 0.2 * pow(y, 3) + 0.3 * pow(z, 20) + 0.05 * pow(x, 5));
    formula(12, (const struct said[]){{"n0", 1.6}, {NULL, 0}}, 1.6);
}

/* n0 at the vertex, alpha its slope there along z; both signs of R. */
static void shells(void **state)
{
    (void)state;
    for (double radius = -3.0; radius < 4.0; radius += 6.0) {
        const struct said said[] = {
            {"n0", 1.6}, {"R", radius}, {"alpha", 0.03}, {"beta", 0.01}, {NULL, 0}};
        struct rmap_field *field = zemax(7, 1, (const double[]){587.56}, said);
        double u = radius - copysign(sqrt(place.x * place.x + place.y * place.y +
                                          (radius - place.z) * (radius - place.z)),
                                     radius);
        assert_near(field_value(field, 0, place), 1.6 + 0.03 * u + 0.01 * u * u, 1e-14);
        assert_near(field_value(field, 0, rmap_vec3(0, 0, 0)), 1.6, 1e-15);
        double n;
        struct rmap_vec3 gradient;
        assert_true(rmap_field_at(field, 0, rmap_vec3(0, 0, 0), &n, &gradient));
        assert_near(gradient.z, 0.03, 1e-15);
        field_check_within(field, 0, 1.0);
        rmap_field_destroy(field);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Selfoc-like numbers; the formulas of gradients 6 and 9 over the wavelength. */
static void dispersive(void **state)
{
    (void)state;
    const double wavelength_nm[2] = {500.0, 800.0};
    double r2 = place.x * place.x + place.y * place.y;
    const struct said nine[] = {{"B", 1.6},    {"C", 0.008},   {"K0", 0.33},
                                {"K1", 0.005}, {"K2", 0.0003}, {NULL, 0}};
    struct rmap_field *field = zemax(9, 2, wavelength_nm, nine);
    for (int c = 0; c < 2; c++) {
        double l = wavelength_nm[c] * 1e-3, root = 0.33 + 0.005 / (l * l) + 0.0003 / pow(l, 4);
        assert_near(field_value(field, c, place),
                    (1.6 + 0.008 / (l * l)) * (1.0 - 0.5 * root * root * r2), 1e-14);
        field_check_within(field, c, 1.0);
    }
    rmap_field_destroy(field);

    const struct said six[] = {{"A0", 1.6},   {"B0", -1e-8}, {"C0", 6e3}, {"D0", 1e7},
                               {"A1", -0.05}, {"C1", 100.0}, {"A4", 0.2}, {NULL, 0}};
    field = zemax(6, 2, wavelength_nm, six);
    for (int c = 0; c < 2; c++) {
        double l2 = wavelength_nm[c] * wavelength_nm[c];
        assert_near(field_value(field, c, place),
                    1.6 - 1e-8 * l2 + 6e3 / l2 + 1e7 / (l2 * l2) + (-0.05 + 100.0 / l2) * r2 +
                        0.2 * pow(r2, 4),
                    1e-14);
        field_check_within(field, c, 1.0);
    }
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void polynomials(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    const int power[4][3] = {{0, 0, 0}, {1, 2, 0}, {0, 1, 3}, {2, 2, 2}};
    const double coefficient[8] = {1.5, 0.2, -0.1, 0.05, 2.25, 0.2, 0.1, -0.05};
    double x = place.x, y = place.y, z = place.z;
    assert_int_equal(
        rmap_field_polynomial(&field, RMAP_SERIES_OF_N, 2, 4, power, coefficient, &err), RMAP_OK);
    assert_near(field_value(field, 0, place),
                1.5 + 0.2 * x * y * y - 0.1 * y * z * z * z + 0.05 * x * x * y * y * z * z, 1e-15);
    field_check_within(field, 0, 1.0);
    field_check_within(field, 1, 1.0);
    rmap_field_destroy(field);
    assert_int_equal(
        rmap_field_polynomial(&field, RMAP_SERIES_OF_N_SQUARED, 1, 4, power, coefficient + 4, &err),
        RMAP_OK);
    field_check_within(field, 0, 1.0);
    rmap_field_destroy(field);
    const int too_high[1][3] = {{0, 65, 0}};
    assert_int_equal(
        rmap_field_polynomial(&field, RMAP_SERIES_OF_N, 1, 1, too_high, coefficient, &err),
        RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void refused(void **state)
{
    (void)state;
    double parameter[RMAP_ZEMAX_PARAMETER_MAX] = {1.5};
    const double line = 587.56;
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_zemax(&field, 8, 1, &line, parameter, &err), RMAP_INPUT);
    assert_int_equal(rmap_field_zemax(&field, 7, 1, &line, parameter, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "R is 0"));
    parameter[2] = (double)NAN;
    assert_int_equal(rmap_field_zemax(&field, 12, 1, &line, parameter, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "cy1"));
    parameter[2] = 0.1;
    for (int type = 1; type <= 12; type++) {
        parameter[1] = 1.0;
        for (int call = 1; call < 6 && rmap_zemax_parameter(type, 0); call++) {
            rmap_alloc_fail_at(call);
            if (rmap_field_zemax(&field, type, 1, &line, parameter, &err) == RMAP_OK)
                rmap_field_destroy(field);
            rmap_alloc_fail_at(0);
            assert_int_equal(rmap_alloc_live(), 0);
        }
    }
    assert_null(rmap_zemax_parameter(8, 0));
    assert_null(rmap_zemax_parameter(13, 0));
    assert_null(rmap_zemax_parameter(-1, 0));
    assert_string_equal(rmap_zemax_parameter(12, 60), "cz20");
    assert_null(rmap_zemax_parameter(12, 61));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(formulas), cmocka_unit_test(shells),
                                       cmocka_unit_test(dispersive), cmocka_unit_test(polynomials),
                                       cmocka_unit_test(refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
