/* SPDX-License-Identifier: MIT
 *
 * Least, greatest, percentiles and uniformities of cells, with what noise does to them.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/detector/uniformity.h"
#include "base/alloc.h"
#include "base/rng.h"
#include "base/vec.h"

enum { N = 400, FIELDS = 60 };

static double normal(uint64_t field, size_t i)
{
    double u[4];
    rmap_rng(7, field, (uint32_t)i, RMAP_RNG_NOISE, u);
    return sqrt(-2.0 * log(u[0])) * cos(2.0 * RMAP_PI * u[1]);
}

static struct rmap_uniformity find(const double *value, const double *error, size_t n, double mean)
{
    struct rmap_uniformity found;
    struct rmap_error err = {0};
    assert_int_equal(rmap_uniformity_find(value, error, n, mean, &found, &err), RMAP_OK);
    return found;
}

/* Fields whose truth is known, seen with noise: without it U0 is found again on average, and lies
 * within the error as often as it should. */
static void check_fields(double depth, double noise)
{
    const double truth = 1.0 - depth;
    double sum = 0.0, raw = 0.0, far = 0.0;
    for (int f = 0; f < FIELDS; f++) {
        double value[N], error[N], mean = 0.0;
        for (size_t i = 0; i < N; i++) {
            error[i] = noise;
            value[i] =
                1.0 + depth * cos(2.0 * RMAP_PI * (double)i / N) + noise * normal((uint64_t)f, i);
            mean += value[i] / N;
        }
        const struct rmap_uniformity found = find(value, error, N, mean);
        raw += (found.u0.value - truth) / FIELDS;
        sum += (found.u0.value - found.u0.bias - truth) / FIELDS;
        far += fabs(found.u0.value - found.u0.bias - truth) > 3.0 * found.u0.standard_error;
    }
    assert_true(raw < -1.5 * noise);
    assert_true(fabs(sum) < 0.25 * fabs(raw));
    assert_true(far <= 0.05 * FIELDS);
}

static void test_noise_is_taken_off(void **state)
{
    (void)state;
    check_fields(0.0, 0.05); /* what is even seems not to be */
    check_fields(0.05, 0.05);
    check_fields(0.1, 0.05);
    check_fields(0.3, 0.05);
}

static void test_without_noise(void **state)
{
    (void)state;
    double value[101], error[101], mean = 1.5;
    for (size_t i = 0; i < 101; i++) {
        value[i] = 1.0 + 0.01 * (double)((i * 37) % 101);
        error[i] = 0.0;
    }
    const struct rmap_uniformity found = find(value, error, 101, mean);
    assert_true(fabs(found.least.value - 1.0) < 1e-12 && fabs(found.greatest.value - 2.0) < 1e-12);
    assert_true(fabs(found.u0.value - 1.0 / 1.5) < 1e-12 && fabs(found.ud.value - 0.5) < 1e-12);
    assert_true(fabs(found.u0.bias) < 1e-12 && fabs(found.u0.standard_error) < 1e-12);
    for (int k = 0; k < RMAP_PERCENTILES; k++)
        assert_true(fabs(found.percentile[k] - (1.0 + 0.01 * rmap_percentile[k])) < 1e-12);
}

static void test_what_is_not_known(void **state)
{
    (void)state;
    const double empty[2] = {0.0, 2.0}, error[2] = {0.0, 0.5}, unknown[2] = {0.5, (double)NAN};
    struct rmap_uniformity found = find(empty, error, 2, 1.0);
    assert_true(!(found.u0.value > 0.0) && isnan(found.u0.standard_error) &&
                isnan(found.least.bias) && isfinite(found.greatest.bias));
    found = find((const double[]){1.0, 2.0}, unknown, 2, 1.5);
    assert_true(isnan(found.u0.standard_error) && isnan(found.greatest.bias));
    found = find((const double[]){0.0, 0.0}, error, 2, 0.0);
    assert_true(isnan(found.u0.value) && isnan(found.ud.value));
}

static void test_memory(void **state)
{
    (void)state;
    const double value[2] = {1.0, 2.0}, error[2] = {0.1, 0.1};
    struct rmap_uniformity found;
    struct rmap_error err = {0};
    for (int64_t at = 1; at <= 3; at++) {
        rmap_alloc_fail_at(at);
        assert_int_equal(rmap_uniformity_find(value, error, 2, 1.5, &found, &err), RMAP_SYSTEM);
    }
    rmap_alloc_fail_at(0);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noise_is_taken_off),
        cmocka_unit_test(test_without_noise),
        cmocka_unit_test(test_what_is_not_known),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
