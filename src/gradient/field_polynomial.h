/* SPDX-License-Identifier: MIT
 *
 * Polynomials in x, y, z, of n or of n^2.
 */
#ifndef RMAP_FIELD_POLYNOMIAL_H
#define RMAP_FIELD_POLYNOMIAL_H

#include "gradient/models.h"

/* n = n_edge sqrt(2 - (r/radius)^2) */
struct rmap_luneburg {
    double n_edge, radius; /* usual: 1 */
};
/* n = n_edge sqrt(1 + (radius^2 - r^2) / focus^2); focus = radius: Luneburg's */
struct rmap_gutman {
    double n_edge, radius, focus;
};
/* n^2 = n0^2 (1 - (alpha rho)^2) */
struct rmap_parabolic {
    double n0, alpha; /* 1/length */
};
/* n = n0 (1 - A rho^2 / 2); A < 0 diverges. A catalogue's gradient constant is g = sqrt(A). */
struct rmap_selfoc {
    double n0, A; /* 1/length^2 */
};

enum rmap_status rmap_field_luneburg(struct rmap_field **field_ret, int n_channel,
                                     const struct rmap_luneburg *parameter,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_field_gutman(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_gutman *parameter,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_field_parabolic(struct rmap_field **field_ret, int n_channel,
                                      const struct rmap_parabolic *parameter,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_field_selfoc(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_selfoc *parameter,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* ---- Power series; with them constant and axial media ---- */

/* q = sum of coefficient[i] s^i */
enum rmap_series_variable {
    RMAP_SERIES_Z,    /* s = z: axial (linear: two coefficients) */
    RMAP_SERIES_RHO2, /* s = x^2 + y^2 */
    RMAP_SERIES_R2    /* s = x^2 + y^2 + z^2 */
};
enum rmap_series_of { RMAP_SERIES_OF_N, RMAP_SERIES_OF_N_SQUARED }; /* q = n, or n^2 */

/* coefficient: [n_channel][n_coefficient], n_coefficient >= 1. One coefficient: a constant. */
enum rmap_status rmap_field_series(struct rmap_field **field_ret, enum rmap_series_variable s,
                                   enum rmap_series_of q, int n_channel, int n_coefficient,
                                   const double *coefficient, struct rmap_error *err) RMAP_MUST_USE;

/* q = sum of coefficient[t] x^i y^j z^k with {i, j, k} = power[t], each in [0, 64].
 * coefficient: [n_channel][n_term]; power: [n_term]. */
enum rmap_status rmap_field_polynomial(struct rmap_field **field_ret, enum rmap_series_of q,
                                       int n_channel, int n_term, const int (*power)[3],
                                       const double *coefficient,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* ---- Zemax gradient surfaces: origin at the surface's vertex, z along the axis ---- */

#define RMAP_ZEMAX_PARAMETER_MAX 64

/* Parameters by the names of the manual, in its order: the i-th of gradient `type`; NULL after the
 * last, and at i = 0 for a type there is none of. Lengths in the field's unit; wavelengths um. */
const char *rmap_zemax_parameter(int type, int i);

/* parameter: as rmap_zemax_parameter lists them; unsaid ones 0. wavelength_nm: [n_channel], used
 * by types with a dispersion of their own. */
enum rmap_status rmap_field_zemax(struct rmap_field **field_ret, int type, int n_channel,
                                  const double *wavelength_nm,
                                  const double parameter[RMAP_ZEMAX_PARAMETER_MAX],
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
