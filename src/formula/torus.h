/* SPDX-License-Identifier: MIT
 *
 * Where a line meets a torus about z: the roots of a quartic, each between two extrema of the
 * polynomial, found by Newton's method that falls back on bisection. Sums, products, quotients and
 * square roots alone, so that every machine finds the same bits.
 */
#ifndef RMAP_TORUS_H
#define RMAP_TORUS_H

#include "base/vec.h"

#define RMAP_TORUS_DEGREE 4
#define RMAP_TORUS_STEPS  80 /* halvings of the interval at worst */

static inline double rmap_polynomial(const double *c, int degree, double t)
{
    double value = c[degree];
    for (int i = degree - 1; i >= 0; i--)
        value = value * t + c[i];
    return value;
}

/* The root between low and high, where the polynomial has two signs. */
static inline double rmap_polynomial_root(const double *c, const double *slope, int degree,
                                          double low, double high)
{
    double at_low = rmap_polynomial(c, degree, low), t = 0.5 * (low + high);
    for (int i = 0; i < RMAP_TORUS_STEPS && low < high; i++) {
        double f = rmap_polynomial(c, degree, t);
        if (f == 0)
            break;
        if ((f < 0) == (at_low < 0))
            low = t;
        else
            high = t;
        double next = t - f / rmap_polynomial(slope, degree - 1, t);
        next = next > low && next < high ? next : 0.5 * (low + high);
        if (next == t)
            break;
        t = next;
    }
    return t;
}

/* Roots in (low, high), in increasing order; how many. Those without a change of sign are none. */
static inline int rmap_polynomial_roots(const double *c, int degree, double low, double high,
                                        double root[RMAP_TORUS_DEGREE])
{
    double derived[RMAP_TORUS_DEGREE + 1][RMAP_TORUS_DEGREE + 1]; /* [k]: of degree k */
    double at[RMAP_TORUS_DEGREE + 1];
    int n = 0;
    for (int i = 0; i <= degree; i++)
        derived[degree][i] = c[i];
    for (int k = degree; k > 1; k--)
        for (int i = 0; i < k; i++)
            derived[k - 1][i] = (i + 1) * derived[k][i + 1];
    for (int k = 1; k <= degree; k++) {
        double from = low;
        int found = 0;
        for (int i = 0; i <= n; i++) {
            double to = i < n ? root[i] : high;
            double f = rmap_polynomial(derived[k], k, from), g = rmap_polynomial(derived[k], k, to);
            if (k == 1 && (f < 0) != (g < 0))
                at[found++] = -derived[1][0] / derived[1][1];
            else if (k > 1 && (f < 0) != (g < 0))
                at[found++] = rmap_polynomial_root(derived[k], derived[k - 1], k, from, to);
            from = to;
        }
        n = found;
        for (int i = 0; i < n; i++)
            root[i] = at[i];
    }
    return n;
}

/* (distance from the middle circle)^2 - minor^2, and its rate along d. */
static inline double rmap_torus_value(double major, double minor, struct rmap_vec3 p,
                                      struct rmap_vec3 d, double *rate)
{
    double rho = sqrt(p.x * p.x + p.y * p.y), off = rho - major, some = rho > 0 ? rho : 1.0;
    *rate = 2 * (off * (p.x * d.x + p.y * d.y) / some + p.z * d.z);
    return off * off + p.z * p.z - minor * minor;
}

/* Distances along the line from p, in lengths of d, in increasing order; how many. own: p lies on
 * the torus, which is none of them. */
static inline int rmap_torus_roots(double major, double minor, struct rmap_vec3 p,
                                   struct rmap_vec3 d, bool own, double t[RMAP_TORUS_DEGREE])
{
    double length = rmap_length(d), reach = major + minor;
    struct rmap_vec3 u = rmap_scale(d, 1 / length);
    double shift = own ? 0 : -rmap_dot(p, u);
    p = rmap_axpy(shift, u, p);
    double square = rmap_dot(p, p), along = rmap_dot(p, u);
    if (!own && !(square <= reach * reach))
        return 0;
    double k = square + major * major - minor * minor, four = 4 * major * major;
    double a = u.x * u.x + u.y * u.y, b = p.x * u.x + p.y * u.y, c = p.x * p.x + p.y * p.y;
    const double quartic[] = {k * k - four * c, 4 * k * along - 2 * four * b,
                              2 * k + 4 * along * along - four * a, 4 * along, 1};
    double high = own ? 2 * reach : reach;
    int n = own ? rmap_polynomial_roots(quartic + 1, RMAP_TORUS_DEGREE - 1, -high, high, t)
                : rmap_polynomial_roots(quartic, RMAP_TORUS_DEGREE, -high, high, t);
    for (int i = 0; i < n; i++) {
        for (int step = 0; step < 2; step++) { /* coefficients are less exact than points */
            double rate, f = rmap_torus_value(major, minor, rmap_axpy(t[i], u, p), u, &rate);
            double by = rate != 0 ? f / rate : 0;
            t[i] -= fabs(by) <= 1e-6 * reach ? by : 0;
        }
        t[i] = (shift + t[i]) / length;
    }
    return n;
}

#endif
