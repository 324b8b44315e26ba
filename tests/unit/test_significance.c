/* SPDX-License-Identifier: MIT
 *
 * The promise: p-values are those of the tables and of closed forms, near and far; corrections keep
 * a family's chance of a false alarm.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/table/significance.h"
#include "base/alloc.h"

static void near_ratio(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance * fabs(want)))
        fail_msg("%.17g is not %.17g", got, want);
}

/* Abramowitz & Stegun (1964), table 26.8: chi-square at given Q and degrees. */
static void tables(void **state)
{
    static const struct {
        double degrees, q, value;
    } row[] = {
        {1, 0.05, 3.84146},   {1, 0.001, 10.8276},   {5, 0.995, 0.411742}, {5, 0.05, 11.0705},
        {10, 0.01, 23.2093},  {30, 0.5, 29.3360},    {30, 0.001, 59.7031}, {100, 0.9, 82.3581},
        {100, 0.05, 124.342}, {100, 0.005, 140.169},
    };
    (void)state;
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        near_ratio(rmap_significance_chi_square(row[i].value, row[i].degrees), row[i].q,
                   1e-4); /* 6 digits */
    near_ratio(rmap_significance_normal(1.959963984540054), 0.05, 1e-12);
    near_ratio(rmap_significance_normal(-5), 5.733031437583869e-07, 1e-10);
}

/* Even degrees: Q = e^-x sum of x^j / j!, j < degrees / 2 (26.4.21). */
static double even(double value, int degrees)
{
    double x = 0.5 * value, sum = 0.0;
    for (int j = 0; j < degrees / 2; j++)
        sum += exp(j * log(x) - x - lgamma(j + 1.0));
    return sum;
}

static void closed_forms(void **state)
{
    (void)state;
    for (int degrees = 2; degrees <= 20000; degrees *= 10)
        for (double z = -4; z <= 8; z += 0.5) {
            double value = degrees + z * sqrt(2.0 * degrees);
            if (value > 0)
                near_ratio(rmap_significance_chi_square(value, degrees), even(value, degrees),
                           1e-9);
        }
    for (double x = 1e-6; x < 1000; x *= 3)
        near_ratio(rmap_significance_chi_square(x, 1), erfc(sqrt(x / 2)), 1e-10);
    assert_true(rmap_significance_chi_square(0, 3) == 1.0);
    assert_true(rmap_significance_chi_square((double)INFINITY, 3) == 0.0);
    assert_true(isnan(rmap_significance_chi_square(1, 0)));
    assert_true(isnan(rmap_significance_chi_square((double)NAN, 2)));
}

static void binomial(void **state)
{
    (void)state;
    near_ratio(rmap_significance_binomial(0, 5, 0.5), 2.0 / 32, 1e-13);
    near_ratio(rmap_significance_binomial(5, 5, 0.5), 2.0 / 32, 1e-13);
    near_ratio(rmap_significance_binomial(1, 5, 0.5), 12.0 / 32, 1e-13);
    assert_true(rmap_significance_binomial(2, 4, 0.5) == 1.0);
    /* P(k >= 3) for 1,000 draws of 1e-3: 1 - sum of three terms */
    double none = pow(0.999, 1000);
    double tail = 1 - none * (1 + 1000 / 999.0 + 1000 * 999 / 2.0 / 999 / 999);
    near_ratio(rmap_significance_binomial(3, 1000, 1e-3), 2 * tail, 1e-9);
    near_ratio(rmap_significance_binomial(997, 1000, 1 - 1e-3), 2 * tail, 1e-9);
}

static void corrections(void **state)
{
    const double p[5] = {0.01, (double)NAN, 0.04, 0.03, 0.005};
    double q[5];
    (void)state;
    assert_int_equal(rmap_significance_correct(RMAP_CORRECTION_HOLM, p, 5, q, NULL), 0);
    near_ratio(q[4], 0.02, 1e-14);
    near_ratio(q[0], 0.03, 1e-14);
    near_ratio(q[3], 0.06, 1e-14);
    near_ratio(q[2], 0.06, 1e-14); /* not less than the one before */
    assert_true(isnan(q[1]));
    assert_int_equal(rmap_significance_correct(RMAP_CORRECTION_SIDAK, p, 5, q, NULL), 0);
    near_ratio(q[0], 1 - pow(0.99, 4), 1e-13);
    assert_int_equal(rmap_significance_correct(RMAP_CORRECTION_NONE, p, 5, q, NULL), 0);
    near_ratio(q[2], 0.04, 0);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables),
        cmocka_unit_test(closed_forms),
        cmocka_unit_test(binomial),
        cmocka_unit_test(corrections),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
