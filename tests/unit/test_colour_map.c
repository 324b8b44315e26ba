/* SPDX-License-Identifier: MIT
 *
 * The promises of the false colours: lightness grows, steps look equal, nothing is clipped.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/table/colour_map.h"

static double decoded(uint8_t byte)
{
    double u = byte / 255.0;
    return u <= 0.04045 ? u / 12.92 : pow((u + 0.055) / 1.055, 2.4);
}

static void lab_of(const uint8_t rgb[3], double lab[3])
{
    const double linear[3] = {decoded(rgb[0]), decoded(rgb[1]), decoded(rgb[2])};
    rmap_rgb_to_oklab(linear, lab);
}

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* Published pairs of the Oklab page: XYZ white is (1, 0, 0); sRGB red, rounded to 3 digits. */
static void oklab_matches_published_values(void **state)
{
    (void)state;
    double lab[3], back[3];
    rmap_rgb_to_oklab((const double[3]){1, 1, 1}, lab);
    assert_true(fabs(lab[0] - 1.0) < 1e-6);
    assert_true(fabs(lab[1]) < 1e-6);
    assert_true(fabs(lab[2]) < 1e-6);
    rmap_rgb_to_oklab((const double[3]){1, 0, 0}, lab);
    assert_true(fabs(lab[0] - 0.628) < 5e-4);
    assert_true(fabs(lab[1] - 0.225) < 5e-4);
    assert_true(fabs(lab[2] - 0.126) < 5e-4);
    rmap_oklab_to_rgb(lab, back);
    assert_true(fabs(back[0] - 1.0) < 1e-6);
    assert_true(fabs(back[1]) < 1e-6);
    assert_true(fabs(back[2]) < 1e-6);
}

static void lightness_grows(void **state)
{
    (void)state;
    struct rmap_colour_map map;
    rmap_colour_map_init(&map);
    double before[3], lab[3];
    lab_of(map.rgb[0], before);
    assert_true(before[0] < 0.15);
    for (int i = 4; i < RMAP_COLOUR_MAP_STEPS; i += 4) {
        lab_of(map.rgb[i], lab);
        assert_true(lab[0] > before[0]);
        before[0] = lab[0];
    }
    lab_of(map.rgb[RMAP_COLOUR_MAP_STEPS - 1], lab);
    assert_true(lab[0] > 0.95);
}

/* Over 16 entries, so that rounding to bytes (about 0.003 in dark colours) does not count. */
static void steps_look_equal(void **state)
{
    (void)state;
    struct rmap_colour_map map;
    rmap_colour_map_init(&map);
    double least = 1e9, most = 0.0;
    for (int i = 0; i + 16 < RMAP_COLOUR_MAP_STEPS; i++) {
        double a[3], b[3];
        lab_of(map.rgb[i], a);
        lab_of(map.rgb[i + 16], b);
        least = fmin(least, distance(a, b));
        most = fmax(most, distance(a, b));
    }
    assert_true(most / least < 1.15);
}

static void values_are_clamped(void **state)
{
    (void)state;
    struct rmap_colour_map map;
    uint8_t rgb[3];
    rmap_colour_map_init(&map);
    rmap_colour_map_at(&map, -3.0, rgb);
    assert_memory_equal(rgb, map.rgb[0], 3);
    rmap_colour_map_at(&map, 7.0, rgb);
    assert_memory_equal(rgb, map.rgb[RMAP_COLOUR_MAP_STEPS - 1], 3);
    rmap_colour_map_at(&map, (double)NAN, rgb);
    assert_memory_equal(rgb, ((uint8_t[3]){128, 128, 128}), 3);
    rmap_srgb_encode((const double[3]){-1.0, 0.2158605, 9.0}, rgb);
    assert_memory_equal(rgb, ((uint8_t[3]){0, 128, 255}), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oklab_matches_published_values),
        cmocka_unit_test(lightness_grows),
        cmocka_unit_test(steps_look_equal),
        cmocka_unit_test(values_are_clamped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
