/* SPDX-License-Identifier: MIT
 *
 * The promise: every unit that stands beside an exported number is turned into its factor to SI and
 * its dimension.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "io/hdf5/h5_unit.h"

static void must_be(const char *name, double si, const double dimension[7])
{
    const struct rmap_h5_unit unit = rmap_h5_unit_named(name);
    assert_string_equal(unit.name, name);
    if (!(fabs(unit.si - si) <= 1e-12 * si))
        fail_msg("%s: factor %.17g, not %.17g", name, unit.si, si);
    for (int k = 0; k < 7; k++)
        if (unit.dimension[k] != dimension[k])
            fail_msg("%s: power %d is %g, not %g", name, k, unit.dimension[k], dimension[k]);
}

static void simple_units(void **state)
{
    (void)state;
    must_be("mm", 1e-3, (const double[7]){1});
    must_be("in", 0.0254, (const double[7]){1});
    must_be("W", 1.0, (const double[7]){2, 1, -3});
    must_be("lm", 1.0, (const double[7]){[6] = 1});
    must_be("s", 1.0, (const double[7]){[2] = 1});
    must_be("deg", acos(-1.0) / 180.0, (const double[7]){0});
    must_be("1", 1.0, (const double[7]){0});
    must_be("", 1.0, (const double[7]){0});
}

static void units_of_quantities(void **state)
{
    (void)state;
    must_be("W/m2", 1.0, (const double[7]){0, 1, -3});
    must_be("W/sr", 1.0, (const double[7]){2, 1, -3});
    must_be("W/(m2 sr)", 1.0, (const double[7]){0, 1, -3});
    must_be("lx", 1.0, (const double[7]){-2, [6] = 1});
    must_be("cd/m2", 1.0, (const double[7]){-2, [6] = 1});
    must_be("cycles/mm", 1e3, (const double[7]){-1});
    must_be("W/mm2", 1e6, (const double[7]){0, 1, -3});
}

static void unknown_words_have_no_dimension(void **state)
{
    (void)state;
    must_be("furlong", 1.0, (const double[7]){0});
    must_be("W/furlong", 1.0, (const double[7]){0});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(simple_units),
        cmocka_unit_test(units_of_quantities),
        cmocka_unit_test(unknown_words_have_no_dimension),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
