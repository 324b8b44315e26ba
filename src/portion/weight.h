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

/* A sum of weights as a number of rays, or of registrations: the nearest; what no traced map holds
 * (NaN, less than 0) is 0. */
static inline uint64_t rmap_weight_whole(double sum)
{
    return sum > 0.0 ? (uint64_t)(fmin(sum, 9e15) + 0.5) : 0;
}

#endif
