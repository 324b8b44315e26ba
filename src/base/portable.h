/* SPDX-License-Identifier: MIT
 *
 * Elementary functions of +, -, x, / and square roots alone: the C library's differ between
 * machines in the last bit. Good to a few units of it, which is what predictions need.
 */
#ifndef RMAP_PORTABLE_H
#define RMAP_PORTABLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Series of the inverse hyperbolic tangent about the nearest power of two. x: normal, > 0. */
static inline double rmap_portable_log(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    int exponent = (int)(bits >> 52) - 1023;
    bits = (bits & UINT64_C(0xfffffffffffff)) | UINT64_C(1023) << 52;
    memcpy(&x, &bits, sizeof x);
    if (x > 1.41421356237309504880) {
        x *= 0.5;
        exponent++;
    }
    double s = (x - 1.0) / (x + 1.0), y = s * s, sum = 0.0;
    for (int k = 23; k >= 1; k -= 2)
        sum = sum * y + 1.0 / (double)k;
    return (double)exponent * 0.69314718055994530942 + 2.0 * s * sum;
}

/* 1 - exp(-x), x >= 0: Taylor series of the remainder to a multiple of ln 2. */
static inline double rmap_portable_one_minus_exp(double x)
{
    if (!(x < 700.0))
        return 1.0;
    int n = (int)(x * 1.44269504088896340736 + 0.5);
    double r = (double)n * 0.69314718055994530942 - x, sum = 0.0, scale = 1.0;
    for (int k = 15; k >= 2; k--)
        sum = (sum + 1.0) * r / (double)k;
    double e = (sum + 1.0) * r; /* exp(r) - 1 */
    for (int k = 0; k < n; k++)
        scale *= 0.5;
    return n == 0 ? -e : 1.0 - scale * (1.0 + e);
}

/* exp(x): Taylor series of the remainder to a multiple of ln 2, its even and odd terms side by
 * side; 0 or infinite beyond 700. */
static inline double rmap_portable_exp(double x)
{
    if (!(x < 700.0 && x > -700.0))
        return x < 0.0 ? 0.0 : x > 0.0 ? HUGE_VAL : x;
    int n = (int)(x * 1.44269504088896340736 + (x < 0.0 ? -0.5 : 0.5));
    double r = (x - (double)n * 0.693147180369123816490) - (double)n * 1.90821492927058770002e-10;
    double y = r * r, scale;
    double even = 1.0 / 87178291200.0, odd = 1.0 / 6227020800.0;
    even = even * y + 1.0 / 479001600.0;
    odd = odd * y + 1.0 / 39916800.0;
    even = even * y + 1.0 / 3628800.0;
    odd = odd * y + 1.0 / 362880.0;
    even = even * y + 1.0 / 40320.0;
    odd = odd * y + 1.0 / 5040.0;
    even = even * y + 1.0 / 720.0;
    odd = odd * y + 1.0 / 120.0;
    even = even * y + 1.0 / 24.0;
    odd = odd * y + 1.0 / 6.0;
    even = even * y + 0.5;
    uint64_t bits = (uint64_t)(1023 + n) << 52;
    memcpy(&scale, &bits, sizeof scale);
    return scale * (1.0 + (r + y * (even + r * odd)));
}

/* x^power, x >= 0. */
static inline double rmap_portable_power(double x, double power)
{
    return x > 0.0 ? rmap_portable_exp(power * rmap_portable_log(x)) : power > 0.0 ? 0.0 : 1.0;
}

/* Angle of (x, y) with the x axis, y >= 0: in [0, pi]. */
static inline double rmap_portable_angle(double x, double y)
{
    double a = x < 0.0 ? -x : x, low = a < y ? a : y, high = a < y ? y : a;
    double t = high > 0.0 ? low / high : 0.0, angle = 0.0;
    for (int k = 0; k < 4; k++) { /* atan t = 2 atan(t / (1 + sqrt(1 + t^2))) */
        t = t / (1.0 + sqrt(1.0 + t * t));
    }
    double square = t * t;
    for (int k = 17; k >= 1; k -= 2)
        angle = 1.0 / (double)k - angle * square;
    angle = 16.0 * (t * angle);
    if (a < y)
        angle = 1.57079632679489661923 - angle;
    return x < 0.0 ? 3.14159265358979323846 - angle : angle;
}

#endif
