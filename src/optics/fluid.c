/* SPDX-License-Identifier: MIT
 *
 * Refractive index of air and sea water over their state.
 */
#include "optics/fluid.h"

#include <math.h>
#include <stddef.h>

double rmap_air_refractivity(double wavelength_nm)
{
    if (!(wavelength_nm >= 185.0))
        return (double)NAN;
    double s2 = 1e6 / (wavelength_nm * wavelength_nm); /* wave number squared, um^-2 */
    return 1e-8 * (5792105.0 / (238.0185 - s2) + 167917.0 / (57.362 - s2));
}

double rmap_seawater_index(double salinity, double temperature_c, double wavelength_nm,
                           double derivative[3])
{
    double s = salinity, t = temperature_c, l = 1.0 / wavelength_nm;
    derivative[0] = 1.779e-4 + t * (-1.05e-6 + t * 1.6e-8) + 0.01155 * l;
    derivative[1] = s * (-1.05e-6 + 3.2e-8 * t) - 4.04e-6 * t - 0.00423 * l;
    derivative[2] = 3.2e-8 * s - 4.04e-6;
    return 1.31405 + s * derivative[0] - 2.02e-6 * t * t +
           l * (15.868 - 0.00423 * t + l * (-4382.0 + l * 1.1455e6));
}

/* U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562), table 4: geopotential height (m) at the foot
 * of each layer, and its gradient of molecular temperature (K/m). */
static const struct {
    double foot, lapse;
} layer[] = {{0.0, -6.5e-3}, {11e3, 0.0},     {20e3, 1e-3},    {32e3, 2.8e-3},
             {47e3, 0.0},    {51e3, -2.8e-3}, {71e3, -2.0e-3}, {84852.0, 0.0}};

#define EARTH_RADIUS_M 6356766.0
/* g0 M0 / R* = 9.80665 x 28.9644 / 8314.32 */
#define HYDROSTATIC_K_PER_M (9.80665 * 28.9644 / 8314.32)

double rmap_standard_density(double height_m, double shift_k)
{
    double height = EARTH_RADIUS_M * height_m / (EARTH_RADIUS_M + height_m); /* geopotential */
    double ground = RMAP_AIR_STANDARD_K + shift_k, temperature = ground, log_pressure = 0.0;
    for (size_t i = 0; i + 1 < sizeof layer / sizeof layer[0] && height > layer[i].foot; i++) {
        double rise = fmin(height, layer[i + 1].foot) - layer[i].foot;
        double above = temperature + layer[i].lapse * rise;
        if (layer[i].lapse == 0.0)
            log_pressure -= HYDROSTATIC_K_PER_M * rise / temperature;
        else
            log_pressure -= HYDROSTATIC_K_PER_M / layer[i].lapse * log(above / temperature);
        temperature = above;
    }
    return exp(log_pressure) * ground / temperature;
}
