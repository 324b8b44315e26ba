/* SPDX-License-Identifier: MIT
 *
 * Tables of the CIE against the sums and chromaticities that they must give, and shares of
 * light on channels.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "near.h"
#include "optics/chromaticity.h"
#include "optics/colour_rendering.h"
#include "optics/illuminant.h"
#include "optics/spectrum.h"
#include "scene/scene.h"

static struct rmap_channels spectral(int n, double from_nm, double step_nm)
{
    struct rmap_channels channels = {RMAP_COLOUR_SPECTRAL, n, {0}};
    for (int i = 0; i < n; i++)
        channels.wavelength_nm[i] = from_nm + step_nm * i;
    return channels;
}

static const struct rmap_channels rgb_channels = {RMAP_COLOUR_RGB, 3, {587.56, 587.56, 587.56}};

/* The colour matching functions have equal sums: white light is x = y = z. */
static void sums_of_the_observer(void **state)
{
    (void)state;
    double sum[3] = {0, 0, 0};
    for (int nm = 360; nm <= 830; nm += 5) {
        double xyz[3];
        rmap_cie1931(nm, xyz);
        for (int i = 0; i < 3; i++)
            sum[i] += xyz[i];
        assert_true(xyz[1] == rmap_luminous_efficiency(nm));
    }
    assert_near(sum[0], 21.3731, 1e-3);
    assert_near(sum[1], 21.3714, 5e-5);
    assert_near(sum[2], 21.3787, 1e-3);
    assert_true(rmap_luminous_efficiency(555.0) == 1.0);
    assert_true(rmap_luminous_efficiency(359.9) == 0.0);
    assert_true(rmap_luminous_efficiency(830.1) == 0.0);
    assert_true(rmap_luminous_efficiency((double)NAN) == 0.0);
    assert_true(rmap_luminous_efficiency(830.0) > 0.0);
}

/* x and y of power every 5 nm. */
static void chromaticity_of(const double *power, double *x, double *y)
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < RMAP_ILLUMINANT_N; i++) {
        const double nm = RMAP_ILLUMINANT_FROM_NM + RMAP_ILLUMINANT_STEP_NM * i;
        double xyz[3];
        rmap_cie1931(nm, xyz);
        for (int k = 0; k < 3 && nm >= 380.0 && nm <= 780.0; k++)
            sum[k] += xyz[k] * power[i];
    }
    *x = sum[0] / (sum[0] + sum[1] + sum[2]);
    *y = sum[1] / (sum[0] + sum[1] + sum[2]);
}

/* CIE 015:2018, tables 3 and 9. */
static void chromaticities_of_illuminants(void **state)
{
    static const struct {
        enum rmap_illuminant which;
        double x, y;
    } due[] = {{RMAP_ILLUMINANT_A, 0.44758, 0.40745},   {RMAP_ILLUMINANT_D50, 0.34567, 0.35851},
               {RMAP_ILLUMINANT_D55, 0.33243, 0.34744}, {RMAP_ILLUMINANT_D75, 0.29903, 0.31488},
               {RMAP_ILLUMINANT_F2, 0.3721, 0.3751},    {RMAP_ILLUMINANT_F11, 0.3805, 0.3769}};
    double power[RMAP_ILLUMINANT_N], x, y;
    (void)state;
    for (size_t i = 0; i < sizeof due / sizeof *due; i++) {
        rmap_illuminant_named(due[i].which, power);
        chromaticity_of(power, &x, &y);
        if (fabs(x - due[i].x) > 1e-4 || fabs(y - due[i].y) > 1e-4)
            fail_msg("illuminant %zu: x %.5f, y %.5f", i, x, y);
    }
    rmap_illuminant_daylight(6504.0, power); /* D65 but for the rounding of its weights */
    chromaticity_of(power, &x, &y);
    assert_true(fabs(x - 0.31272) < 1e-4 && fabs(y - 0.32903) < 1e-4);
    for (int i = 0; i < RMAP_ILLUMINANT_N; i++)
        assert_true(fabs(power[i] -
                         rmap_d65(RMAP_ILLUMINANT_FROM_NM + RMAP_ILLUMINANT_STEP_NM * i)) < 0.05);
}

/* Published: (u, v) of 1960, CCT and Duv by Ohno 2014, as colour-science 0.4 has them; far ones are
 * refused. Points of the locus itself, and beside it, come back. */
static void temperatures(void **state)
{
    static const double due[][4] = {{0.1978, 0.3122, 6507.4748, 0.0032233}};
    static const double kelvin[] = {1200.0, 2000.0, 2855.5, 4321.0, 6504.0, 20000.0, 60000.0};
    struct rmap_planck_locus locus;
    struct rmap_chromaticity of;
    (void)state;
    rmap_planck_locus_fill(&locus);
    for (size_t i = 0; i < sizeof due / sizeof *due; i++) {
        const double u = due[i][0], v = due[i][1]; /* Y = 1 */
        const double xyz[3] = {1.5 * u / v, 1.0, (4.0 - u - 10.0 * v) / (2.0 * v)};
        rmap_chromaticity_of(&locus, xyz, &of);
        assert_near(of.u, u, 1e-12);
        assert_near(of.v, 1.5 * v, 1e-12);
        assert_true(fabs(of.kelvin - due[i][2]) < 0.2);
        assert_true(fabs(of.duv - due[i][3]) < 1e-6);
    }
    for (size_t i = 0; i < sizeof kelvin / sizeof *kelvin; i++) {
        double xyz[3] = {0.0, 0.0, 0.0};
        for (int nm = 360; nm <= 830; nm += 5) {
            double bar[3];
            rmap_cie1931(nm, bar);
            for (int k = 0; k < 3; k++)
                xyz[k] += bar[k] * rmap_blackbody(kelvin[i], nm);
        }
        rmap_chromaticity_of(&locus, xyz, &of);
        assert_near(of.kelvin, kelvin[i], 1e-4 * kelvin[i]);
        assert_true(fabs(of.duv) < 1e-7);
        xyz[1] *= 1.02; /* greener: above the locus */
        rmap_chromaticity_of(&locus, xyz, &of);
        assert_true(of.duv > 1e-4);
    }
    const double green[3] = {0.1, 1.0, 0.1}, dark[3] = {0.0, 0.0, 0.0};
    rmap_chromaticity_of(&locus, green, &of);
    assert_true(isnan(of.kelvin) && isnan(of.duv) && of.y > 0.8);
    rmap_chromaticity_of(&locus, dark, &of);
    assert_true(isnan(of.x) && isnan(of.u) && isnan(of.kelvin));
}

/* CIE 15:2004, table T.7: Ra of F2 is 64, of F11 83; R9 of F2 is far below 0. */
static void rendering(void **state)
{
    static const struct {
        enum rmap_illuminant which;
        double kelvin, general, tolerance;
    } due[] = {{RMAP_ILLUMINANT_A, 2856.0, 100.0, 0.05},
               {RMAP_ILLUMINANT_D50, 5000.0, 100.0, 0.1},
               {RMAP_ILLUMINANT_D75, 7500.0, 100.0, 0.1},
               {RMAP_ILLUMINANT_F2, 4225.0, 64.2337, 0.1},
               {RMAP_ILLUMINANT_F11, 3999.0, 82.8, 0.5}};
    const struct rmap_channels fine = spectral(81, 380.0, 5.0), coarse = spectral(21, 380.0, 20.0),
                               lines = spectral(3, 450.0, 80.0), wide = spectral(15, 380.0, 30.0);
    double power[RMAP_ILLUMINANT_N], mean[RMAP_CHANNEL_MAX];
    struct rmap_cri cri;
    (void)state;
    for (size_t i = 0; i < sizeof due / sizeof *due; i++) {
        rmap_illuminant_named(due[i].which, power);
        rmap_illuminant_means(power, &fine, mean);
        rmap_cri_of(&fine, mean, due[i].kelvin, &cri);
        if (fabs(cri.general - due[i].general) > due[i].tolerance)
            fail_msg("illuminant %zu: Ra %.3f, not %.3f", i, cri.general, due[i].general);
        assert_true(due[i].which != RMAP_ILLUMINANT_F2 || cri.special[8] < -50.0);
        rmap_illuminant_means(power, &coarse, mean);
        rmap_cri_of(&coarse, mean, due[i].kelvin, &cri);
        assert_true(fabs(cri.general - due[i].general) < 4.0);
    }
    assert_null(rmap_cri_refused(&fine));
    assert_null(rmap_cri_refused(&coarse));
    assert_non_null(rmap_cri_refused(&lines));
    assert_non_null(rmap_cri_refused(&wide));
    assert_non_null(rmap_cri_refused(&rgb_channels));
}

/* Bands of any width share out what is there; an LED's line is whole, and half as wide as said. */
static void means_over_bands(void **state)
{
    static const double step[] = {5.0, 10.0, 20.0};
    double power[RMAP_ILLUMINANT_N], mean[RMAP_CHANNEL_MAX], of_lamp[3], of_led[3];
    (void)state;
    rmap_illuminant_named(RMAP_ILLUMINANT_F11, power);
    for (int k = 0; k < 3; k++) {
        struct rmap_channels channels = {.mode = RMAP_COLOUR_SPECTRAL};
        channels.n = (int)(400.0 / step[k]) + 1;
        if (channels.n > RMAP_CHANNEL_MAX)
            continue;
        for (int i = 0; i < channels.n; i++)
            channels.wavelength_nm[i] = 380.0 + step[k] * i;
        of_lamp[k] = of_led[k] = 0.0;
        rmap_illuminant_means(power, &channels, mean);
        for (int i = 0; i < channels.n; i++)
            of_lamp[k] += mean[i] * step[k];
        rmap_led_means(523.0, 30.0, &channels, mean);
        for (int i = 0; i < channels.n; i++)
            of_led[k] += mean[i] * step[k];
        assert_true(fabs(of_led[k] - 1.0) < 1e-12);
        assert_true(fabs(of_lamp[k] / of_lamp[0] - 1.0) < 1e-3);
    }
    rmap_led_steps(523.0, 30.0, power);
    const double peak = power[(525 - 300) / 5], half = power[(540 - 300) / 5];
    assert_true(fabs(half / peak - exp(-4.0 * log(2.0) * (17.0 * 17.0 - 4.0) / 900.0)) < 0.02);
}

/* Chromaticity of D65: x = 0.31272, y = 0.32903 (CIE 15:2004, table T.3), white in sRGB. */
static void chromaticity_of_d65(void **state)
{
    (void)state;
    double sum[3] = {0, 0, 0}, rgb[3];
    for (int nm = 360; nm <= 830; nm += 5) {
        double xyz[3];
        rmap_cie1931(nm, xyz);
        for (int i = 0; i < 3; i++)
            sum[i] += xyz[i] * rmap_d65(nm);
    }
    double total = sum[0] + sum[1] + sum[2];
    assert_near(sum[0] / total, 0.31272, 2e-5);
    assert_near(sum[1] / total, 0.32903, 3e-5);
    rmap_xyz_to_rgb(sum, rgb);
    for (int i = 0; i < 3; i++)
        assert_near(rgb[i] / sum[1], 1.0, 1.5e-3);
    assert_true(rmap_d65(560.0) == 100.0);
    assert_true(rmap_d65(299.0) == 0.0);
}

/* Wien's law: the maximum of B(lambda, T) lies at 2.897771955e-3 m K / T. */
static void blackbody_maximum(void **state)
{
    (void)state;
    double t = 5000.0, peak = 2.897771955e6 / t;
    assert_true(rmap_blackbody(t, peak) > rmap_blackbody(t, peak * 1.001));
    assert_true(rmap_blackbody(t, peak) > rmap_blackbody(t, peak * 0.999));
    /* against Planck's formula as it stands */
    double c2 = 1.438776877e7;
    double planck =
        pow(560.0 / 450.0, 5) * (exp(c2 / (560.0 * t)) - 1) / (exp(c2 / (450.0 * t)) - 1);
    assert_near(rmap_blackbody(t, 450.0), planck, 1e-12 * planck);
    assert_true(isfinite(rmap_blackbody(1.0, 400.0)) && isfinite(rmap_blackbody(1e9, 400.0)));
}

static void tables(void **state)
{
    (void)state;
    const double x[] = {400, 500, 700}, y[] = {1, 3, 2};
    struct rmap_table1 table = {3, x, y};
    assert_true(rmap_table1_at(&table, 300) == 1.0 && rmap_table1_at(&table, 400) == 1.0);
    assert_near(rmap_table1_at(&table, 450), 2.0, 1e-15);
    assert_true(rmap_table1_at(&table, 500) == 3.0);
    assert_near(rmap_table1_at(&table, 600), 2.5, 1e-15);
    assert_true(rmap_table1_at(&table, 900) == 2.0);
}

static void shares_of_continuous_light(void **state)
{
    (void)state;
    struct rmap_channels channels = spectral(81, 380, 5);
    struct rmap_spectrum d65 = {.kind = RMAP_SPECTRUM_D65};
    struct rmap_error err = {0};
    double watt[RMAP_CHANNEL_MAX], lumen[RMAP_CHANNEL_MAX], sum = 0.0, visible = 0.0;
    assert_int_equal(rmap_spectrum_shares(&d65, &channels, 0, watt, &err), RMAP_OK);
    assert_int_equal(rmap_spectrum_shares(&d65, &channels, 1, lumen, &err), RMAP_OK);
    for (int i = 0; i < 81; i++) {
        sum += watt[i];
        visible += watt[i] * rmap_luminous_efficiency(channels.wavelength_nm[i]);
    }
    assert_near(sum, 1.0, 1e-14);
    for (int i = 0; i < 81; i++)
        assert_near(lumen[i],
                    watt[i] * rmap_luminous_efficiency(channels.wavelength_nm[i]) / visible, 1e-14);
    /* D65 from 380 to 780 nm: about 203 lm / W */
    assert_near(rmap_luminous_efficacy(&channels, watt), 203.0, 3.0);
}

static void shares_of_lines(void **state)
{
    (void)state;
    struct rmap_channels channels = spectral(3, 450, 100);
    const double line[] = {451, 640, 660}, power[] = {1, 2, 1};
    struct rmap_spectrum lines = {.kind = RMAP_SPECTRUM_LINES, .table = {3, line, power}};
    struct rmap_error err = {0};
    double share[3];
    assert_int_equal(rmap_spectrum_shares(&lines, &channels, 0, share, &err), RMAP_OK);
    assert_true(share[0] == 0.25 && share[1] == 0.0 && share[2] == 0.75);
    const double infrared[] = {1064};
    struct rmap_channels laser = spectral(1, 1064, 1);
    struct rmap_spectrum invisible = {.kind = RMAP_SPECTRUM_LINES, .table = {1, infrared, power}};
    assert_int_equal(rmap_spectrum_shares(&invisible, &laser, 0, share, &err), RMAP_OK);
    assert_true(share[0] == 1.0);
    assert_int_equal(rmap_spectrum_shares(&invisible, &laser, 1, share, &err), RMAP_INPUT);
    assert_true(err.text[0] != 0);
}

/* D65 is the white of sRGB: equal shares of watts, luminance weights in lumens. */
static void shares_in_rgb(void **state)
{
    (void)state;
    struct rmap_spectrum d65 = {.kind = RMAP_SPECTRUM_D65};
    struct rmap_error err = {0};
    double share[3];
    assert_int_equal(rmap_spectrum_shares(&d65, &rgb_channels, 0, share, &err), RMAP_OK);
    for (int i = 0; i < 3; i++)
        assert_near(share[i], 1.0 / 3.0, 1e-3);
    assert_int_equal(rmap_spectrum_shares(&d65, &rgb_channels, 1, share, &err), RMAP_OK);
    assert_near(share[0], 0.2126, 1e-3);
    assert_near(share[1], 0.7152, 1e-3);
    assert_near(share[2], 0.0722, 1e-3);
    struct rmap_spectrum warm = {.kind = RMAP_SPECTRUM_BLACKBODY, .temperature_k = 2700};
    assert_int_equal(rmap_spectrum_shares(&warm, &rgb_channels, 0, share, &err), RMAP_OK);
    assert_true(share[0] > share[1] && share[1] > share[2] && share[2] >= 0.0);
}

static void sampled_reflectances(void **state)
{
    (void)state;
    struct rmap_channels channels = spectral(3, 450, 100);
    const double x[] = {400, 700}, y[] = {0.1, 0.7};
    struct rmap_spectrum ramp = {.kind = RMAP_SPECTRUM_TABLE, .table = {2, x, y}};
    struct rmap_spectrum red = {.kind = RMAP_SPECTRUM_RGB, .rgb = {0.9, 0.5, 0.1}};
    struct rmap_spectrum grey = {.kind = RMAP_SPECTRUM_EQUAL, .value = 0.7};
    double value[3];
    rmap_spectrum_sample(&ramp, &channels, value);
    assert_near(value[1], 0.4, 1e-15);
    rmap_spectrum_sample(&ramp, &rgb_channels, value);
    assert_near(value[0], 0.1 + 0.6 * (640.0 - 400.0) / 300.0, 1e-12); /* middle of the band */
    assert_near(value[2], 0.1 + 0.6 * (445.0 - 400.0) / 300.0, 1e-12);
    rmap_spectrum_sample(&red, &channels, value);
    assert_true(value[0] == 0.1 && value[1] == 0.5 && value[2] == 0.9);
    rmap_spectrum_sample(&red, &rgb_channels, value);
    assert_true(value[0] == 0.9 && value[2] == 0.1);
    rmap_spectrum_sample(&grey, &rgb_channels, value);
    assert_true(value[0] == 0.7 && value[1] == 0.7 && value[2] == 0.7);
}

static void display_colours(void **state)
{
    (void)state;
    struct rmap_channels laser = spectral(1, 633, 1), infrared = spectral(1, 1064, 1);
    const double one[3] = {1, 0, 0}, none[3] = {0, 0, 0};
    double rgb[3];
    rmap_colour_display(&laser, one, 0, rgb);
    assert_true(rgb[0] == 1.0 && rgb[1] < 0.2 && rgb[2] == 0.0);
    rmap_colour_display(&laser, one, 1, rgb);
    assert_true(rgb[0] == 1.0 && rgb[1] < 0.2 && rgb[2] == 0.0);
    rmap_colour_display(&infrared, one, 0, rgb);
    assert_true(rgb[0] == 0.5 && rgb[1] == 0.5 && rgb[2] == 0.5);
    rmap_colour_display(&laser, none, 0, rgb);
    assert_true(rgb[0] == 0.0 && rgb[1] == 0.0 && rgb[2] == 0.0);
    const double lumen[3] = {0.2126390058715104, 0.7151686787677559, 0.0721923153607337};
    rmap_colour_display(&rgb_channels, lumen, 1, rgb);
    assert_near(rgb[1], 1.0, 1e-12);
    assert_near(rgb[2], 1.0, 1e-12);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(sums_of_the_observer),
        cmocka_unit_test(chromaticities_of_illuminants),
        cmocka_unit_test(temperatures),
        cmocka_unit_test(rendering),
        cmocka_unit_test(means_over_bands),
        cmocka_unit_test(chromaticity_of_d65),
        cmocka_unit_test(blackbody_maximum),
        cmocka_unit_test(tables),
        cmocka_unit_test(shares_of_continuous_light),
        cmocka_unit_test(shares_of_lines),
        cmocka_unit_test(shares_in_rgb),
        cmocka_unit_test(sampled_reflectances),
        cmocka_unit_test(display_colours),
    };
    return cmocka_run_group_tests_name("spectrum", test, NULL, NULL);
}
