/* SPDX-License-Identifier: MIT
 *
 * The promise: tables of glare have the interreflection of CIE 190:2010, table 5, and the position
 * indices of CIE 117:1995, table 4.1.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/photometry/position_index.h"
#include "analysis/photometry/ugr_table.h"

/* FT,FW, FT,WW - 1 and FT,CW, to three digits; reflectances of floor, walls, ceiling. */
static void test_transfer(void **state)
{
    (void)state;
    static const struct {
        double x, y, reflectance[3], share[3];
    } row[] = {{2, 2, {0.2, 0.5, 0.7}, {0.220, 0.422, 0.646}},
               {2, 12, {0.2, 0.5, 0.7}, {0.160, 0.290, 0.443}},
               {4, 8, {0.2, 0.3, 0.7}, {0.106, 0.117, 0.283}},
               {8, 8, {0.2, 0.5, 0.5}, {0.071, 0.137, 0.147}},
               {12, 8, {0.2, 0.3, 0.5}, {0.058, 0.067, 0.120}},
               {4, 12, {0.2, 0.3, 0.3}, {0.074, 0.083, 0.104}}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        double share[3];
        rmap_ugr_transfer(row[i].x, row[i].y, row[i].reflectance, share);
        for (int k = 0; k < 3; k++)
            assert_true(fabs(share[k] - row[i].share[k]) < 0.00051);
    }
}

static void test_position_index(void **state)
{
    (void)state;
    assert_true(fabs(rmap_position_index(0, 0) - 1.0) < 1e-12);
    assert_true(fabs(rmap_position_index(1.0, 0.5) - 3.91) < 1e-9);
    assert_true(fabs(rmap_position_index(3.0, 1.9) - 16.0) < 1e-9);
    assert_true(fabs(rmap_position_index(0.05, 0.5) - 0.5 * (2.86 + 2.75)) < 1e-9);
    assert_true(fabs(rmap_position_index(0.25, 0.15) - 0.25 * (1.30 + 1.50 + 1.38 + 1.60)) < 1e-9);
    assert_true(rmap_position_index(0.0, 1.75) == 0.0); /* beside a value that is not there */
    assert_true(rmap_position_index(0.0, 1.7) > 0.0);
    assert_true(rmap_position_index(3.01, 0.0) == 0.0);
    assert_true(rmap_position_index(0.9, 1.91) == 0.0);
    /* Levin 1975 fitted them, for the visual comfort probability: within a tenth. */
    for (double aside = 0.0; aside <= 3.0; aside += 0.25)
        for (double above = 0.1; above <= 1.6; above += 0.25) {
            const double degree = 57.29577951308232, tau = atan2(aside, above) * degree;
            const double sigma = atan(hypot(aside, above)) * degree;
            const double fit =
                exp((35.2 - 0.31889 * tau - 1.22 * exp(-2.0 * tau / 9.0)) * 1e-3 * sigma +
                    (21.0 + 0.26667 * tau - 0.002963 * tau * tau) * 1e-5 * sigma * sigma);
            assert_true(fabs(rmap_position_index(aside, above) / fit - 1.0) < 0.11);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_transfer),
                                       cmocka_unit_test(test_position_index)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
