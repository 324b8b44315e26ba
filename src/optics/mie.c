/* SPDX-License-Identifier: MIT
 *
 * Light scattered by a sphere.
 */
#include "optics/mie.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "formula/azimuth.h"
#include "optics/complex_number.h"

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

/* Angles side by side. */
enum { ABREAST = 16 };

static void intensities(const double *mu, size_t n_term, const double complex *a,
                        const double complex *b, double *intensity)
{
    double re1[ABREAST] = {0.0}, im1[ABREAST] = {0.0}, re2[ABREAST] = {0.0}, im2[ABREAST] = {0.0},
           pi0[ABREAST] = {0.0}, pi1[ABREAST];
    for (int k = 0; k < ABREAST; k++)
        pi1[k] = 1.0;
    for (size_t i = 1; i <= n_term; i++) {
        const double n = (double)i, f = (2.0 * n + 1.0) / (n * (n + 1.0)), up = (2.0 * n + 1.0) / n,
                     down = (n + 1.0) / n;
        const double ar = f * creal(a[i]), ai = f * cimag(a[i]), br = f * creal(b[i]),
                     bi = f * cimag(b[i]);
        for (int k = 0; k < ABREAST; k++) {
            const double tau = n * mu[k] * pi1[k] - (n + 1.0) * pi0[k],
                         pi2 = up * mu[k] * pi1[k] - down * pi0[k];
            re1[k] += ar * pi1[k] + br * tau;
            im1[k] += ai * pi1[k] + bi * tau;
            re2[k] += ar * tau + br * pi1[k];
            im2[k] += ai * tau + bi * pi1[k];
            pi0[k] = pi1[k];
            pi1[k] = pi2;
        }
    }
    for (int k = 0; k < ABREAST; k++)
        intensity[k] =
            0.5 * (re1[k] * re1[k] + im1[k] * im1[k] + re2[k] * re2[k] + im2[k] * im2[k]);
}

static double along(double complex a, double complex b)
{
    return creal(a) * creal(b) + cimag(a) * cimag(b);
}

static void sum_up(double x, size_t n_term, const double complex *a, const double complex *b,
                   struct rmap_mie *mie)
{
    double sign = -1.0;
    double complex back = 0.0;
    *mie = (struct rmap_mie){.scattered = 0.0};
    for (size_t i = 1; i <= n_term; i++, sign = -sign) {
        const double n = (double)i, f = 2.0 * n + 1.0;
        mie->extinct += f * (creal(a[i]) + creal(b[i]));
        mie->scattered += f * (creal(a[i]) * creal(a[i]) + cimag(a[i]) * cimag(a[i]) +
                               creal(b[i]) * creal(b[i]) + cimag(b[i]) * cimag(b[i]));
        back += sign * f * (a[i] - b[i]);
        mie->cosine += f / (n * (n + 1.0)) * along(a[i], b[i]);
        if (i < n_term)
            mie->cosine +=
                n * (n + 2.0) / (n + 1.0) * (along(a[i], a[i + 1]) + along(b[i], b[i + 1]));
    }
    mie->cosine *= 2.0 / mie->scattered;
    mie->extinct *= 2.0 / (x * x);
    mie->scattered *= 2.0 / (x * x);
    mie->back = along(back, back) / (x * x);
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
    sum_up(x, n_term, a, b, mie);
    for (size_t i = 0; i < n_angle; i += ABREAST) {
        const size_t left = n_angle - i < ABREAST ? n_angle - i : ABREAST;
        double mu[ABREAST] = {0.0}, some[ABREAST];
        memcpy(mu, cosine + i, left * sizeof *mu);
        intensities(mu, n_term, a, b, some);
        memcpy(intensity + i, some, left * sizeof *some);
    }
    rmap_free(room);
    return RMAP_OK;
}
