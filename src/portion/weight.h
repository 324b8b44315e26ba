/* SPDX-License-Identifier: MIT
 *
 * Weights of rays, and their squares, as multiples of 2^-21: sums of such are exact in double, and
 * so the same in whatever order rays come.
 */
#ifndef RMAP_WEIGHT_H
#define RMAP_WEIGHT_H

#include <math.h>
#include <stdint.h>

/* The nearest from 0 to 1024: exact for 2^21 rays of the greatest weight, or 2^31 of about 1. */
static inline double rmap_weight_round(double weight)
{
    const double unit = 1 << 21;
    return weight < 1024.0 ? (double)(int64_t)(weight * unit + 0.5) / unit : 1024.0;
}

/* The product of what a ray adds to two sums: their sum is exact up to 2^32. Whole ones stay what
 * they are. */
static inline double rmap_weight_product(double a, double b)
{
    const double unit = 1 << 21;
    return floor(a * b * unit + 0.5) / unit;
}

static inline double rmap_weight_squared(double weight)
{
    return rmap_weight_product(weight, weight);
}

#endif
