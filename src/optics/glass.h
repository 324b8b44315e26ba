/* SPDX-License-Identifier: MIT
 *
 * Refractive index and internal absorption of a material over wavelength.
 *
 * The formulas are those of the refractiveindex.info database ("Dispersion formulas", with its
 * numbers; L in um), as the makers publish them:
 *
 *   1  n^2 = 1 + c0 + sum c_i L^2 / (L^2 - c_j^2)     Sellmeier 1871
 *   2  n^2 = 1 + c0 + sum c_i L^2 / (L^2 - c_j)       the same, as SCHOTT, OHARA and CDGM print it
 *   3  n^2 = c0 + sum c_i L^(c_j)                     SCHOTT's formula until 1992, HOYA, SUMITA
 *   4  n^2 = c0 + c1 L^c2 / (L^2 - c3^c4) + c5 L^c6 / (L^2 - c7^c8) + sum c_i L^(c_j)
 *   5  n = c0 + sum c_i L^(c_j)                       Cauchy 1836
 */
#ifndef RMAP_GLASS_H
#define RMAP_GLASS_H

#include <stdbool.h>
#include <stddef.h>

#define RMAP_GLASS_ROWS_MAX         256
#define RMAP_GLASS_COEFFICIENTS_MAX 24

struct rmap_glass_table {
    size_t n;
    double wavelength_nm[RMAP_GLASS_ROWS_MAX], value[RMAP_GLASS_ROWS_MAX];
};

struct rmap_glass {
    char group[16], name[32]; /* "SCHOTT", "N-BK7" */
    char source[480];         /* where the numbers come from */
    double nd, vd;            /* as published; NaN where they are not */
    double from_nm, to_nm;    /* range of the data */
    int formula;              /* 1 to 5; 0: the table of indices */
    size_t n_coefficient;
    double coefficient[RMAP_GLASS_COEFFICIENTS_MAX];
    bool
        linear; /* between rows of the table of indices; false: by the cubic through four of them */
    struct rmap_glass_table index, extinction; /* extinction.n 0: none is published */
};

/* NaN where the formula has no real index. A table's ends stand for what lies beyond. */
double rmap_glass_index(const struct rmap_glass *glass, double wavelength_nm);

/* n - wavelength dn/dwavelength: by the formula's derivative, or that of the cubic spline through
 * the table, beyond whose ends it is n. NaN where there is no index. */
double rmap_glass_group_index(const struct rmap_glass *glass, double wavelength_nm);

/* Extinction coefficient k, linear between its rows, constant beyond its ends; 0 without any. */
double rmap_glass_extinction(const struct rmap_glass *glass, double wavelength_nm);

/* What a path in the glass lets through, without its surfaces; NaN outside the published range. */
double rmap_glass_transmittance(const struct rmap_glass *glass, double wavelength_nm,
                                double path_mm);

/* Lines of helium and hydrogen by which glasses are named (ISO 7944). */
#define RMAP_LINE_D_NM 587.5618
#define RMAP_LINE_F_NM 486.1327
#define RMAP_LINE_C_NM 656.2725

/* Abbe number (nd - 1) / (nF - nC) of the data; NaN unless all three lines are in their range. */
double rmap_glass_abbe(const struct rmap_glass *glass);

#endif
