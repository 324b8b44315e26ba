/* SPDX-License-Identifier: MIT
 *
 * Standard errors of fluxes, rays of a source being independent samples (docs/physics.md).
 */
#ifndef RMAP_FLUX_ERROR_H
#define RMAP_FLUX_ERROR_H

#include <math.h>

/* A source's part of the variance: n rays of it were emitted, with this flux per weight each; sum
 * and squares are of the weights of those that count, a ray's first summed. NaN: n < 2. */
static inline double rmap_flux_variance(double flux_per_weight, double n, double sum,
                                        double squares)
{
    return n < 2.0 ? (double)NAN
                   : flux_per_weight * flux_per_weight * n / (n - 1.0) * (squares - sum * sum / n);
}

/* The same of sums that may count each registration as a ray: with more of them than rays they
 * cannot be of a ray each, and of how many they are such sums do not know. Then NaN. */
static inline double rmap_flux_variance_if_rays(double flux_per_weight, double n, double sum,
                                                double squares)
{
    return squares - sum * sum / n >= -1e-9 * squares
               ? rmap_flux_variance(flux_per_weight, n, sum, squares)
               : (double)NAN;
}

/* Rounding may take a variance of 0 below it; NaN stays. */
static inline double rmap_flux_error(double variance)
{
    return isnan(variance) ? (double)NAN : sqrt(fmax(variance, 0.0));
}

#endif
