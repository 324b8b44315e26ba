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
    size_t low = 0, high = n - 1;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (ascending[middle] > value)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

#endif
