/* SPDX-License-Identifier: MIT
 *
 * Refractive index of air and sea water over their state.
 */
#ifndef RMAP_FLUID_H
#define RMAP_FLUID_H

/* Dry air: n - 1 at 15 C, 101325 Pa, 450 ppm CO2 (Ciddor 1996, doi:10.1364/AO.35.001566, eq. 1).
 * The fit holds from 300 to 1690 nm; NaN below 185 nm. */
double rmap_air_refractivity(double wavelength_nm);
#define RMAP_AIR_STANDARD_K  288.15
#define RMAP_AIR_STANDARD_PA 101325.0

/* Sea water over salinity (per mille), temperature (Celsius) and wavelength (Quan & Fry 1995,
 * doi:10.1364/AO.34.003477, eq. 3): n = c[0] + c[1] S with c over T and the wavelength. The fit
 * holds for 0-35 per mille, 0-30 C, 400-700 nm. derivative: dn/dS, dn/dT, d2n/dT2. */
double rmap_seawater_index(double salinity, double temperature_c, double wavelength_nm,
                           double derivative[3]);

/* Density of the U.S. Standard Atmosphere 1976 over its value at sea level, at a geometric height
 * in [0, 86000] m, for air shift_k warmer everywhere and the same pressure on the ground. */
double rmap_standard_density(double height_m, double shift_k);

#endif
