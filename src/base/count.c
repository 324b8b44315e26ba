/* SPDX-License-Identifier: MIT
 *
 * Marks and counts, summed.
 */
#include "base/count.h"

#include "base/wide.h"

RMAP_WIDE size_t rmap_count_ones(const uint8_t *mark, size_t n)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k++)
        count += mark[k];
    return count;
}

RMAP_WIDE size_t rmap_count_equal(const uint8_t *mark, size_t n, uint8_t wanted)
{
    size_t count = 0;
    for (size_t k = 0; k < n; k++)
        count += mark[k] == wanted;
    return count;
}

RMAP_WIDE bool rmap_sums_to(const uint32_t *count, size_t n, uint64_t wanted)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += count[i];
    return sum == wanted;
}
