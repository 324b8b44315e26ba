/* SPDX-License-Identifier: MIT
 *
 * Illuminants of CIE 015:2018.
 */
#include "optics/illuminant.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* clang-format off */
/* Mean and first two characteristic vectors of daylight, table 6, with what lies halfway. */
static const double daylight[3][RMAP_ILLUMINANT_N] = {{
    0.04, 3.02, 6.0, 17.8, 29.6, 42.45, 55.3, 56.3, 57.3, 59.55, 61.8, 61.65, 61.5, 65.15, 68.8,
    66.1, 63.4, 64.6, 65.8, 80.3, 94.8, 99.8, 104.8, 105.35, 105.9, 101.35, 96.8, 105.35, 113.9,
    119.75, 125.6, 125.55, 125.5, 123.4, 121.3, 121.3, 121.3, 117.4, 113.5, 113.3, 113.1, 111.95,
    110.8, 108.65, 106.5, 107.65, 108.8, 107.05, 105.3, 104.85, 104.4, 102.2, 100.0, 98.0, 96.0,
    95.55, 95.1, 92.1, 89.1, 89.8, 90.5, 90.4, 90.3, 89.35, 88.4, 86.2, 84.0, 84.55, 85.1, 83.5,
    81.9, 82.25, 82.6, 83.75, 84.9, 83.1, 81.3, 76.6, 71.9, 73.1, 74.3, 75.35, 76.4, 69.85, 63.3,
    67.5, 71.7, 74.35, 77.0, 71.1, 65.2, 56.45, 47.7, 58.15, 68.6, 66.8, 65.0, 65.5, 66.0, 63.5,
    61.0, 57.15, 53.3, 56.1, 58.9, 60.4, 61.9},
    {
    0.02, 2.26, 4.5, 13.45, 22.4, 32.2, 42.0, 41.3, 40.6, 41.1, 41.6, 39.8, 38.0, 40.2, 42.4, 40.45,
    38.5, 36.75, 35.0, 39.2, 43.4, 44.85, 46.3, 45.1, 43.9, 40.5, 37.1, 36.9, 36.7, 36.3, 35.9,
    34.25, 32.6, 30.25, 27.9, 26.1, 24.3, 22.2, 20.1, 18.15, 16.2, 14.7, 13.2, 10.9, 8.6, 7.35, 6.1,
    5.15, 4.2, 3.05, 1.9, 0.95, 0.0, -0.8, -1.6, -2.55, -3.5, -3.5, -3.5, -4.65, -5.8, -6.5, -7.2,
    -7.9, -8.6, -9.05, -9.5, -10.2, -10.9, -10.8, -10.7, -11.35, -12.0, -13.0, -14.0, -13.8, -13.6,
    -12.8, -12.0, -12.65, -13.3, -13.1, -12.9, -11.75, -10.6, -11.1, -11.6, -11.9, -12.2, -11.2,
    -10.2, -9.0, -7.8, -9.5, -11.2, -10.8, -10.4, -10.5, -10.6, -10.15, -9.7, -9.0, -8.3, -8.8,
    -9.3, -9.55, -9.8},
    {
    0.0, 1.0, 2.0, 3.0, 4.0, 6.25, 8.5, 8.15, 7.8, 7.25, 6.7, 6.0, 5.3, 5.7, 6.1, 4.55, 3.0, 2.1,
    1.2, 0.05, -1.1, -0.8, -0.5, -0.6, -0.7, -0.95, -1.2, -1.9, -2.6, -2.75, -2.9, -2.85, -2.8,
    -2.7, -2.6, -2.6, -2.6, -2.2, -1.8, -1.65, -1.5, -1.4, -1.3, -1.25, -1.2, -1.1, -1.0, -0.75,
    -0.5, -0.4, -0.3, -0.15, 0.0, 0.1, 0.2, 0.35, 0.5, 1.3, 2.1, 2.65, 3.2, 3.65, 4.1, 4.4, 4.7,
    4.9, 5.1, 5.9, 6.7, 7.0, 7.3, 7.95, 8.6, 9.2, 9.8, 10.0, 10.2, 9.25, 8.3, 8.95, 9.6, 9.05, 8.5,
    7.75, 7.0, 7.3, 7.6, 7.8, 8.0, 7.35, 6.7, 5.95, 5.2, 6.3, 7.4, 7.1, 6.8, 6.9, 7.0, 6.7, 6.4,
    5.95, 5.5, 5.8, 6.1, 6.3, 6.5}};

/* Of fluorescent lamps, table 10.1: 380 to 780 nm. */
enum { LAMP_FIRST = 16, LAMP_N = 81 };
static const double f2[LAMP_N] = {
    1.18, 1.48, 1.84, 2.15, 3.44, 15.69, 3.85, 3.74, 4.19, 4.62, 5.06, 34.98, 11.81, 6.27, 6.63,
    6.93, 7.19, 7.4, 7.54, 7.62, 7.65, 7.62, 7.62, 7.45, 7.28, 7.15, 7.05, 7.04, 7.16, 7.47, 8.04,
    8.88, 10.01, 24.88, 16.64, 14.59, 16.16, 17.56, 18.62, 21.47, 22.79, 19.29, 18.66, 17.73, 16.54,
    15.21, 13.8, 12.36, 10.95, 9.65, 8.4, 7.32, 6.31, 5.43, 4.68, 4.02, 3.45, 2.96, 2.55, 2.19,
    1.89, 1.64, 1.53, 1.27, 1.1, 0.99, 0.88, 0.76, 0.68, 0.61, 0.56, 0.54, 0.51, 0.47, 0.47, 0.43,
    0.46, 0.47, 0.4, 0.33, 0.27},
    f11[LAMP_N] = {
    0.91, 0.63, 0.46, 0.37, 1.29, 12.68, 1.59, 1.79, 2.46, 3.33, 4.49, 33.94, 12.13, 6.95, 7.19,
    7.12, 6.72, 6.13, 5.46, 4.79, 5.66, 14.29, 14.96, 8.97, 4.72, 2.33, 1.47, 1.1, 0.89, 0.83, 1.18,
    4.9, 39.59, 72.84, 32.61, 7.52, 2.83, 1.96, 1.67, 4.43, 11.28, 14.76, 12.73, 9.74, 7.33, 9.72,
    55.27, 42.58, 13.18, 13.16, 12.26, 5.11, 2.07, 2.34, 3.58, 3.01, 2.48, 2.14, 1.54, 1.33, 1.46,
    1.94, 2.0, 1.2, 1.35, 4.1, 5.58, 2.51, 0.57, 0.27, 0.23, 0.21, 0.24, 0.24, 0.2, 0.24, 0.32,
    0.26, 0.16, 0.12, 0.09};
/* clang-format on */

static double nm_of(int i)
{
    return RMAP_ILLUMINANT_FROM_NM + RMAP_ILLUMINANT_STEP_NM * i;
}

/* Section 4.1.1, with the constants of 1931. */
static double incandescent(double nm)
{
    const double ratio = 560.0 / nm, c2 = 1.435e7;
    return 100.0 * pow(ratio, 5.0) * expm1(c2 / (2848.0 * 560.0)) / expm1(c2 / (2848.0 * nm));
}

/* Section 4.1.2. The weights of named illuminants are rounded to three decimals. */
static void set_daylight(double kelvin, bool rounded, double power[RMAP_ILLUMINANT_N])
{
    const double t = 1000.0 / kelvin;
    const double x = kelvin <= 7000.0 ? 0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
                                      : 0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064));
    const double y = -0.275 + x * (2.870 - 3.000 * x), m = 0.0241 + 0.2562 * x - 0.7341 * y;
    double m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m,
           m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
    if (rounded) {
        m1 = round(1000.0 * m1) / 1000.0;
        m2 = round(1000.0 * m2) / 1000.0;
    }
    for (int i = 0; i < RMAP_ILLUMINANT_N; i++)
        power[i] = fmax(daylight[0][i] + m1 * daylight[1][i] + m2 * daylight[2][i], 0.0);
}

void rmap_illuminant_daylight(double kelvin, double power[RMAP_ILLUMINANT_N])
{
    set_daylight(kelvin, false, power);
}

void rmap_illuminant_named(enum rmap_illuminant illuminant, double power[RMAP_ILLUMINANT_N])
{
    const double nominal = 1.4388 / 1.4380; /* of c2 since the temperatures were named */
    const double *lamp = illuminant == RMAP_ILLUMINANT_F2 ? f2 : f11;
    memset(power, 0, RMAP_ILLUMINANT_N * sizeof *power);
    switch (illuminant) {
    case RMAP_ILLUMINANT_A:
        for (int i = 0; i < RMAP_ILLUMINANT_N; i++)
            power[i] = incandescent(nm_of(i));
        break;
    case RMAP_ILLUMINANT_D50:
        set_daylight(5000.0 * nominal, true, power);
        break;
    case RMAP_ILLUMINANT_D55:
        set_daylight(5500.0 * nominal, true, power);
        break;
    case RMAP_ILLUMINANT_D75:
        set_daylight(7500.0 * nominal, true, power);
        break;
    case RMAP_ILLUMINANT_F2:
    case RMAP_ILLUMINANT_F11:
        memcpy(power + LAMP_FIRST, lamp, sizeof f2);
        break;
    }
}

/* From a to b of the steps that stand about the wavelengths of a table. */
static double integral(const double power[RMAP_ILLUMINANT_N], double a, double b)
{
    const double half = 0.5 * RMAP_ILLUMINANT_STEP_NM;
    double sum = 0.0;
    for (int i = 0; i < RMAP_ILLUMINANT_N; i++)
        sum += power[i] * fmax(fmin(b, nm_of(i) + half) - fmax(a, nm_of(i) - half), 0.0);
    return sum;
}

static void band_of(const struct rmap_channels *channels, int i, double *a, double *b)
{
    double below, above;
    rmap_channel_steps(channels, i, &below, &above);
    *a = channels->wavelength_nm[i] - 0.5 * below;
    *b = channels->wavelength_nm[i] + 0.5 * above;
}

void rmap_illuminant_means(const double power[RMAP_ILLUMINANT_N],
                           const struct rmap_channels *channels, double *mean)
{
    for (int i = 0; i < channels->n; i++) {
        double a, b;
        band_of(channels, i, &a, &b);
        mean[i] = integral(power, a, b) / (b - a);
    }
}

static double led_mean(double peak_nm, double width_nm, double a, double b)
{
    const double scale = 2.0 * sqrt(log(2.0)) / width_nm;
    return 0.5 * (erf(scale * (b - peak_nm)) - erf(scale * (a - peak_nm))) / (b - a);
}

void rmap_led_means(double peak_nm, double width_nm, const struct rmap_channels *channels,
                    double *mean)
{
    for (int i = 0; i < channels->n; i++) {
        double a, b;
        band_of(channels, i, &a, &b);
        mean[i] = led_mean(peak_nm, width_nm, a, b);
    }
}

void rmap_led_steps(double peak_nm, double width_nm, double power[RMAP_ILLUMINANT_N])
{
    const double half = 0.5 * RMAP_ILLUMINANT_STEP_NM;
    for (int i = 0; i < RMAP_ILLUMINANT_N; i++)
        power[i] = led_mean(peak_nm, width_nm, nm_of(i) - half, nm_of(i) + half);
}
