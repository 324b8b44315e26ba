/* SPDX-License-Identifier: MIT
 *
 * What there is to know of many numbers before they are sorted into bins.
 */
#ifndef RMAP_STATS_MEASURE_H
#define RMAP_STATS_MEASURE_H

#include <stddef.h>

struct rmap_stats_measured {
    double low, high; /* low > high: no number */
    double sum, squared;
};

/* Of n numbers. Sums are taken in their order and rounded: of the same numbers as a whole, they are
 * the same bits. */
struct rmap_stats_measured rmap_stats_measure(const double *value, size_t n);

/* The least of n numbers above 0; infinity without one. */
double rmap_stats_least_positive(const double *value, size_t n);

#endif
