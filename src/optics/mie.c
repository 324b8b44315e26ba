/* SPDX-License-Identifier: MIT
 *
 * Light scattered by a sphere.
 */
#include "optics/mie.h"

#include <complex.h>
#include <math.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "formula/azimuth.h"

/* Terms that count (Wiscombe 1980, doi:10.1364/AO.19.001505). */
static size_t terms_of(double x)
{
    return (size_t)(x + 4.05 * rmap_portable_power(x, 1.0 / 3.0) + 2.0);
}

/* Logarithmic derivatives of psi at m x, downwards from where they are forgotten. */
static void derivatives(double complex mx, size_t n_term, size_t from, double complex *d)
{
    double complex next = 0.0;
    for (size_t n = from; n >= 1; n--) {
        const double complex r = (double)n / mx;
        next = r - 1.0 / (next + r);
        if (n - 1 <= n_term)
            d[n - 1] = next;
    }
}

/* Of one sphere: coefficients of the electric and the magnetic waves, n from 1. */
static void coefficients(double x, double complex m, size_t n_term, const double complex *d,
                         double complex *a, double complex *b)
{
    double cosine, sine, turns = x / (2.0 * RMAP_PI);
    rmap_azimuth(turns - floor(turns), &cosine, &sine);
    double psi0 = cosine, psi1 = sine, chi0 = -sine, chi1 = cosine; /* n - 2, n - 1 */
    for (size_t n = 1; n <= n_term; n++) {
        const double f = (2.0 * (double)n - 1.0) / x;
        const double psi = f * psi1 - psi0, chi = f * chi1 - chi0;
        const double complex xi = CMPLX(psi, -chi), xi1 = CMPLX(psi1, -chi1);
        const double complex u = d[n] / m + (double)n / x, v = d[n] * m + (double)n / x;
        a[n] = (u * psi - psi1) / (u * xi - xi1);
        b[n] = (v * psi - psi1) / (v * xi - xi1);
        psi0 = psi1;
        psi1 = psi;
        chi0 = chi1;
        chi1 = chi;
    }
}

static double intensity_at(double mu, size_t n_term, const double complex *a,
                           const double complex *b)
{
    double complex s1 = 0.0, s2 = 0.0;
    double pi0 = 0.0, pi1 = 1.0;
    for (size_t n = 1; n <= n_term; n++) {
        const double tau = (double)n * mu * pi1 - ((double)n + 1.0) * pi0;
        const double f = (2.0 * (double)n + 1.0) / ((double)n * ((double)n + 1.0));
        s1 += f * (a[n] * pi1 + b[n] * tau);
        s2 += f * (a[n] * tau + b[n] * pi1);
        const double pi2 =
            ((2.0 * (double)n + 1.0) * mu * pi1 - ((double)n + 1.0) * pi0) / (double)n;
        pi0 = pi1;
        pi1 = pi2;
    }
    return 0.5 * (creal(s1) * creal(s1) + cimag(s1) * cimag(s1) + creal(s2) * creal(s2) +
                  cimag(s2) * cimag(s2));
}

enum rmap_status rmap_mie_scatter(double x, double n, double k, size_t n_angle,
                                  const double *cosine, double *intensity, struct rmap_mie *mie,
                                  struct rmap_error *err)
{
    const double complex m = CMPLX(n, k);
    const size_t n_term = terms_of(x);
    const double inside = x * sqrt(n * n + k * k);
    const size_t from = (inside > (double)n_term ? (size_t)inside : n_term) + 16;
    double complex *room = rmap_alloc(3 * (n_term + 2), sizeof *room);
    if (!room)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sphere");
    double complex *d = room, *a = room + n_term + 2, *b = a + n_term + 2;
    derivatives(m * x, n_term, from, d);
    coefficients(x, m, n_term, d, a, b);
    *mie = (struct rmap_mie){0.0, 0.0};
    for (size_t i = 1; i <= n_term; i++) {
        const double f = 2.0 * (double)i + 1.0;
        mie->extinct += f * (creal(a[i]) + creal(b[i]));
        mie->scattered += f * (creal(a[i]) * creal(a[i]) + cimag(a[i]) * cimag(a[i]) +
                               creal(b[i]) * creal(b[i]) + cimag(b[i]) * cimag(b[i]));
    }
    mie->extinct *= 2.0 / (x * x);
    mie->scattered *= 2.0 / (x * x);
    for (size_t i = 0; i < n_angle; i++)
        intensity[i] = intensity_at(cosine[i], n_term, a, b);
    rmap_free(room);
    return RMAP_OK;
}
