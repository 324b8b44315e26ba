/* SPDX-License-Identifier: MIT
 *
 * Refractive index over wavelength: Sellmeier's equation, tables, and the built-in glass list.
 */
#ifndef RMAP_DISPERSION_H
#define RMAP_DISPERSION_H

#include <stddef.h>

/* n^2 = 1 + sum B L^2 / (L^2 - C), L in um, C in um^2 (Sellmeier 1871). */
#define RMAP_SELLMEIER_MAX 6
struct rmap_sellmeier {
    size_t n_term;
    double b[RMAP_SELLMEIER_MAX], c[RMAP_SELLMEIER_MAX];
};

/* NaN where n^2 < 1 or at a pole. */
double rmap_sellmeier_index(const struct rmap_sellmeier *sellmeier, double wavelength_nm);

struct rmap_glass {
    const char *name;
    struct rmap_sellmeier sellmeier;
    double from_nm, to_nm; /* range of the fit */
    const char *source;    /* where the coefficients come from */
};

/* By name, case-insensitive; NULL when unknown. */
const struct rmap_glass *rmap_glass_find(const char *name);

/* The i-th built-in glass, NULL after the last; sorted by name. */
const struct rmap_glass *rmap_glass_at(size_t i);

#endif
