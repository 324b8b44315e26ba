/* SPDX-License-Identifier: MIT
 *
 * Ticks of axes, logarithmic ones too: in the range, ascending, at numbers that people write,
 * neither too few nor too many.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/table/figure_axes.h"

static void must_be(const struct rmap_ticks *ticks, const double *value, int n)
{
    assert_int_equal(ticks->n, n);
    for (int i = 0; i < n; i++)
        assert_true(fabs(ticks->value[i] - value[i]) <= 1e-12 * value[i]);
}

static void powers_of_ten_where_they_are_many(void **state)
{
    (void)state;
    struct rmap_ticks ticks;
    rmap_ticks_powers(0.5e-3, 3e2, 10, &ticks);
    must_be(&ticks, (const double[]){1e-3, 1e-2, 1e-1, 1, 10, 100}, 6);
}

static void twos_and_fives_between_few(void **state)
{
    (void)state;
    struct rmap_ticks ticks;
    rmap_ticks_powers(1.48, 166.0, 10, &ticks);
    must_be(&ticks, (const double[]){2, 5, 10, 20, 50, 100}, 6);
    rmap_ticks_powers(1.0, 10.0, 10, &ticks); /* both ends */
    must_be(&ticks, (const double[]){1, 2, 5, 10}, 4);
}

static void round_numbers_in_a_short_range(void **state)
{
    (void)state;
    struct rmap_ticks ticks;
    rmap_ticks_powers(300.0, 420.0, 6, &ticks);
    assert_in_range(ticks.n, 2, 6);
    for (int i = 0; i < ticks.n; i++)
        assert_true(ticks.value[i] >= 300.0 && ticks.value[i] <= 420.0);
}

static void any_range_has_ticks_inside_it(void **state)
{
    (void)state;
    for (double low = 1e-12; low < 1e12; low *= 3.7)
        for (double ratio = 1.01; ratio < 1e20; ratio *= 1.9) {
            struct rmap_ticks ticks;
            rmap_ticks_powers(low, low * ratio, 10, &ticks);
            assert_in_range(ticks.n, 2, RMAP_TICK_MAX);
            for (int i = 0; i < ticks.n; i++) {
                assert_true(ticks.value[i] >= low * (1 - 1e-8));
                assert_true(ticks.value[i] <= low * ratio * (1 + 1e-8));
                assert_true(i == 0 || ticks.value[i] > ticks.value[i - 1]);
            }
        }
}

static void a_narrow_axis_has_two(void **state)
{
    (void)state;
    for (int most = 2; most < 8; most++)
        for (double low = -7.3; low < 9.0; low += 0.37)
            for (double span = 1e-3; span < 1e3; span *= 1.3) {
                struct rmap_ticks ticks;
                rmap_ticks_linear(low, low + span, most, &ticks);
                assert_in_range(ticks.n, 2, most < 4 ? 6 : most + 1);
                assert_true(ticks.value[0] >= low - 1e-8 * span);
                assert_true(ticks.value[ticks.n - 1] <= low + span * (1 + 1e-8));
            }
    struct rmap_ticks ticks;
    rmap_ticks_linear(-4.0, 4.0, 3, &ticks); /* not 0 alone, of steps of 5 */
    assert_int_equal(ticks.n, 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers_of_ten_where_they_are_many),
        cmocka_unit_test(twos_and_fives_between_few),
        cmocka_unit_test(round_numbers_in_a_short_range),
        cmocka_unit_test(a_narrow_axis_has_two),
        cmocka_unit_test(any_range_has_ticks_inside_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
