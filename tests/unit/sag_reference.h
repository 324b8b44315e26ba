/* SPDX-License-Identifier: MIT
 *
 * Sags in long double, by the sums that define their polynomials: Zernike's by factorials, Forbes's
 * Q^con by them too, Q^bfs one after the other.
 */
#ifndef SAG_REFERENCE_H
#define SAG_REFERENCE_H

#include "geometry/sag.h"

typedef long double real;

static inline real factorial(int n)
{
    return n < 2 ? 1 : n * factorial(n - 1);
}

/* Zernike's R_n^m(u). */
static inline real radial(int n, int m, real u)
{
    real sum = 0;
    for (int k = 0; k <= (n - m) / 2; k++)
        sum += (k % 2 ? -1 : 1) * factorial(n - k) /
               (factorial(k) * factorial((n + m) / 2 - k) * factorial((n - m) / 2 - k)) *
               powl(u, n - 2 * k);
    return sum;
}

/* Forbes 2010, (B.1) to (B.10). */
static inline real q_bfs(int m, real x)
{
    real f[32] = {2, sqrtl(19) / 2}, g[32] = {-0.5L}, h[32] = {0};
    real p_before = 2, p = 6 - 8 * x, q_before = 1, q = (13 - 16 * x) / sqrtl(19);
    for (int k = 2; k <= m; k++) {
        h[k - 2] = -k * (k - 1) / (2 * f[k - 2]);
        g[k - 1] = -(1 + g[k - 2] * h[k - 2]) / f[k - 1];
        f[k] = sqrtl(k * (k + 1) + 3 - g[k - 1] * g[k - 1] - h[k - 2] * h[k - 2]);
        real p_next = (2 - 4 * x) * p - p_before;
        real q_next = (p_next - g[k - 1] * q - h[k - 2] * q_before) / f[k];
        p_before = p;
        p = p_next;
        q_before = q;
        q = q_next;
    }
    return m == 0 ? 1 : q;
}

static inline real sag_conic(real c, real k, real s)
{
    return c * s / (1 + sqrtl(fmaxl(0, 1 - (1 + k) * c * c * s)));
}

static inline real sag_base(const struct rmap_sag *sag, real x, real y)
{
    const double *c = sag->curvature, *k = sag->conic;
    real power = 0, of = sag->base == RMAP_SAG_TOROID ? y : sqrtl(x * x + y * y);
    for (int i = sag->n_power; i-- > 0;)
        power = (power + sag->power[i]) * of;
    switch (sag->base) {
    case RMAP_SAG_CONIC:
        return sag_conic(c[0], k[0], x * x + y * y) + power;
    case RMAP_SAG_BICONIC:
        return (c[0] * x * x + c[1] * y * y) /
                   (1 + sqrtl(1 - (1 + (real)k[0]) * c[0] * c[0] * x * x -
                              (1 + (real)k[1]) * c[1] * c[1] * y * y)) +
               power;
    case RMAP_SAG_TOROID:
        break;
    }
    real f = sag_conic(c[1], k[1], y * y) + power;
    if (c[0] == 0)
        return f;
    real radius = 1 / (real)c[0], rest = radius - f;
    return radius - copysignl(sqrtl(rest * rest - x * x), radius);
}

static inline real sag_reference(const struct rmap_sag *sag, real x, real y)
{
    real z = sag_base(sag, x, y), s = x * x + y * y;
    const real phi = sag->n_zernike > 0 ? atan2l(y, x) : 0;
    for (int d = 0; d < sag->n_xy; d++)
        for (int j = 0; j <= d; j++)
            if (sag->xy[rmap_sag_term(d, j)] != 0)
                z += sag->xy[rmap_sag_term(d, j)] * powl(x / sag->xy_norm, d - j) *
                     powl(y / sag->xy_norm, j);
    for (int n = 0; n < sag->n_zernike; n++)
        for (int k = 0; k <= n; k++) {
            const int m = 2 * k - n;
            if (sag->zernike[rmap_sag_term(n, k)] == 0)
                continue;
            z += sag->zernike[rmap_sag_term(n, k)] *
                 radial(n, m < 0 ? -m : m, sqrtl(s) / sag->zernike_norm) *
                 (m < 0 ? sinl(-m * phi) : cosl(m * phi));
        }
    for (int m = 0; m < sag->n_qcon; m++)
        z += sag->qcon[m] * radial(2 * m + 4, 4, sqrtl(s) / sag->qcon_norm);
    for (int m = 0; m < sag->n_qbfs; m++) {
        real t = s / ((real)sag->qbfs_norm * sag->qbfs_norm), c = sag->curvature[0];
        real k = sag->conic[0], slope2 = c * c * s / (1 - (1 + k) * c * c * s); /* of the conic */
        z += sag->qbfs[m] * t * (1 - t) * q_bfs(m, t) * sqrtl(1 + slope2);
    }
    return sag->fresnel ? 0 : z;
}

#endif
