/* SPDX-License-Identifier: MIT
 *
 * The promise: what a portion says about the angles of its registrations holds for each of them, is
 * a quarter of a degree wide, comes back from its rows, and says nothing of what has no angle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "analysis/criterion/registration_angle.h"
#include "base/rng.h"
#include "compact/angles.h"

enum { MOST = 4099 };

static uint8_t outcome(uint16_t quarter, const struct rmap_interval *interval)
{
    struct rmap_angle_ends ends;
    rmap_angle_ends_set(&ends, interval);
    return rmap_angle_outcome(quarter, interval, &ends);
}

static void check(const struct rmap_detector *detector, const float *direction)
{
    double bound[2];
    const double angle = rmap_registration_angle(detector, direction);
    const uint16_t quarter = rmap_angle_quarter(detector, direction);
    assert_true(rmap_angle_bounds(quarter, bound));
    assert_true(bound[0] <= angle && angle <= bound[1] && bound[1] - bound[0] < 0.2500001);
    assert_true(rmap_angle_is_in(quarter, detector, direction));
    assert_false(rmap_angle_is_in(quarter + 2, detector, direction) &&
                 quarter + 2 <= RMAP_ANGLE_MAX);
    const struct rmap_interval near = {angle - 0.3, angle + 0.3, false},
                               far = {angle + 0.3, 500.0, false}, across = {angle, angle, true};
    assert_int_equal(outcome(quarter, &near), RMAP_OUTCOME_YES);
    assert_int_equal(outcome(quarter, &far), RMAP_OUTCOME_NO);
    assert_int_equal(outcome(quarter, &across), RMAP_OUTCOME_OPEN);
}

static void test_bounds(void **state)
{
    struct rmap_detector detector = {.type = RMAP_DETECTOR_PLANE};
    (void)state;
    for (uint64_t i = 0; i < MOST; i++) {
        double u[4], v[4];
        rmap_rng(11, i, 0, 0, u);
        rmap_rng(11, i, 1, 0, v);
        detector.axis = rmap_normalize(rmap_vec3(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5));
        detector.type = u[3] < 0.5 ? RMAP_DETECTOR_PLANE : RMAP_DETECTOR_INTENSITY;
        check(&detector, (float[]){(float)(v[0] - 0.5), (float)(v[1] - 0.5), (float)(v[2] - 0.5)});
        const double close = i % 2 ? 1e-7 : -1e-7; /* at the ends, 0 and 180 degrees */
        const struct rmap_vec3 d = rmap_axpy(close, detector.x, detector.axis);
        check(&detector, (float[]){(float)d.x, (float)d.y, (float)d.z});
        check(&detector, (float[]){(float)-d.x, (float)-d.y, (float)-d.z});
    }
    /* Whole quarters, told to one side or the other. */
    detector.axis = rmap_vec3(0.0, 0.0, 1.0);
    for (int k = 0; k <= 4 * 180; k++) {
        const double turn = k / 4.0 * (RMAP_PI / 180.0);
        check(&detector, (float[]){(float)sin(turn), 0.0f, (float)cos(turn)});
    }
}

static void test_none(void **state)
{
    static const float odd[][3] = {{0.0f, 0.0f, 0.0f}, {NAN, 0.0f, 1.0f}, {0.0f, 0.0f, INFINITY}};
    const struct rmap_detector detector = {.axis = {0.0, 0.0, 1.0}};
    const struct rmap_interval all = {-INFINITY, INFINITY, false};
    (void)state;
    for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) {
        const uint16_t quarter = rmap_angle_quarter(&detector, odd[k]);
        assert_int_equal(outcome(quarter, &all), RMAP_OUTCOME_OPEN);
        assert_true(rmap_angle_is_in(quarter, &detector, odd[k]));
    }
}

static void test_rows(void **state)
{
    static uint16_t quarter[MOST], back[MOST], parts[MOST];
    static uint32_t degrees[MOST];
    const struct rmap_angle_rows rows = {degrees, parts};
    (void)state;
    for (size_t n = 0; n <= 40; n++) {
        for (size_t i = 0; i < n; i++) {
            double u[4];
            rmap_rng(5, i, (uint32_t)n, 0, u);
            quarter[i] = u[1] < 0.1 ? RMAP_ANGLE_NONE : (uint16_t)(u[0] * (RMAP_ANGLE_MAX + 1));
        }
        degrees[rmap_angle_degree_rows(n)] = parts[rmap_angle_part_rows(n)] = 0xabcd;
        rmap_angles_pack(quarter, n, degrees, parts);
        rmap_angles_unpack(&rows, n, back);
        assert_memory_equal(quarter, back, n * sizeof *back);
        assert_int_equal(degrees[rmap_angle_degree_rows(n)], 0xabcd);
        assert_int_equal(parts[rmap_angle_part_rows(n)], 0xabcd);
    }
    memset(degrees, 0xff, sizeof degrees); /* anything may stand in a file */
    memset(parts, 0xff, sizeof parts);
    rmap_angles_unpack(&rows, 40, back);
    for (size_t i = 0; i < 40; i++)
        assert_true(back[i] > RMAP_ANGLE_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bounds), cmocka_unit_test(test_none),
                                       cmocka_unit_test(test_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
