/* SPDX-License-Identifier: MIT
 *
 * Cherenkov light of a charged particle that is faster than light in its medium.
 */
#ifndef RMAP_CHERENKOV_H
#define RMAP_CHERENKOV_H

/* Photons per metre of path are the product of two: Frank & Tamm 1937 (C. R. Acad. Sci. URSS 14,
 * 109) as in the Particle Data Group's Review of Particle Physics 2022 (doi:10.1093/ptep/ptac097),
 * eq. 34.45: 2 pi alpha z^2 sin^2(theta) d lambda / lambda^2, which is flat in energy. By portable
 * operations.
 *
 * What the particle decides, of z elementary charges and speed beta (of light in vacuum), where the
 * index is n: z^2 sin^2(theta), cos(theta) = 1 / (n beta); 0 below the threshold n beta = 1. */
static inline double rmap_cherenkov_strength(double n, double beta, double charge)
{
    const double cosine = 1.0 / (n * beta);
    return cosine < 1.0 ? charge * charge * (1.0 - cosine) * (1.0 + cosine) : 0.0;
}

/* The rest, between two wavelengths in vacuum: photons per metre of unit strength. */
double rmap_cherenkov_band(const double band_nm[2]);

#endif
