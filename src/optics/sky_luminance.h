/* SPDX-License-Identifier: MIT
 *
 * How bright the sky is over direction, by +, -, x, / and square roots alone but for Perez's five
 * numbers: src/compact finds rays of it again, whose directions are those of cells that brightness
 * alone does not move.
 */
#ifndef RMAP_SKY_LUMINANCE_H
#define RMAP_SKY_LUMINANCE_H

#include <stdbool.h>

/* L / L_zenith = f(chi) phi(Z) / (f(Z_sun) phi(0)), phi(Z) = 1 + a exp(b / cos Z),
 * f(chi) = 1 + c (exp(d chi) - exp(d pi / 2)) + e cos^2 chi; chi: angle to the sun, Z: to the
 * zenith (Perez, Seals, Michalsky 1993, doi:10.1016/0038-092X(93)90017-I, eq. 3; ISO 15469:2004,
 * eqs. 1 to 5). */
struct rmap_sky_pattern {
    double a, b, c, d, e;
    bool bare; /* without the term of pi / 2, as Perez has it */
};

/* A sky type of CIE S 011 (ISO 15469:2004, table 1): 1 to 15. */
#define RMAP_CIE_SKIES 15
struct rmap_sky_pattern rmap_cie_sky(int kind);

/* The sky by its clearness and brightness (Perez, Seals, Michalsky 1993, table 1), of irradiances
 * in W/m2: `direct` of a plane that faces the sun, `diffuse` of the ground. zenith_deg: of the sun;
 * nearness: rmap_sun_nearness. */
struct rmap_sky_pattern rmap_perez_sky(double direct, double diffuse, double zenith_deg,
                                       double nearness);

/* It differs around the zenith: the sun's place matters. */
bool rmap_sky_pattern_has_sun(const struct rmap_sky_pattern *sky);

/* f(chi) phi(Z) by the cosines of both angles; 0 below the horizon. Cosines in [-1, 1]. */
double rmap_sky_pattern_at(const struct rmap_sky_pattern *sky, double cos_zenith, double cos_sun);

#endif
