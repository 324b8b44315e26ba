/* SPDX-License-Identifier: MIT
 *
 * Chromaticity of CIE XYZ (2-degree observer of 1931): x and y, u' and v', and how far it lies from
 * Planck's radiators: correlated colour temperature and Duv.
 */
#ifndef RMAP_CHROMATICITY_H
#define RMAP_CHROMATICITY_H

#include <stdbool.h>

struct rmap_chromaticity {
    double x, y, u, v;  /* u' and v' of 1976; all NaN of no light */
    double kelvin, duv; /* NaN: beyond 1000 to 100000 K, or 0.05 from Planck's locus (CIE 015) */
};

/* u and v of 1960 of Planck's radiators, in equal steps of 1/T. */
enum { RMAP_PLANCK_N = 496 };
struct rmap_planck_locus {
    double uv[RMAP_PLANCK_N][2];
};
void rmap_planck_locus_fill(struct rmap_planck_locus *locus);

void rmap_chromaticity_of(const struct rmap_planck_locus *locus, const double xyz[3],
                          struct rmap_chromaticity *chromaticity);

/* u and v of 1960: v = 2/3 v'. */
void rmap_uv1960(const double xyz[3], double uv[2]);

#endif
