/* SPDX-License-Identifier: MIT
 *
 * A place in an ascending list.
 */
#ifndef RMAP_SEARCH_H
#define RMAP_SEARCH_H

#include <stddef.h>

/* The first of n > 0 numbers that is greater than `value`, the last where none is: what a uniform
 * number draws from cumulative shares, and never one without a share of its own. */
static inline size_t rmap_first_above(const double *ascending, size_t n, double value)
{
    const double *from = ascending;
    while (n > 1) { /* without a branch, which would be guessed wrongly half of the times */
        const size_t half = n / 2;
        from += half & -(size_t) !(from[half - 1] > value);
        n -= half;
    }
    return (size_t)(from - ascending);
}

#endif
