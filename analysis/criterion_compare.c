/* SPDX-License-Identifier: MIT */
#include "analysis/criterion_compare.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion_evaluate.h"
#include "base/wide.h"

/* Counts that an interval holds: least <= count <= least + span, or, when `flip`, the others. */
struct whole_range {
    bool empty, flip;
    uint32_t least, span;
};

static struct whole_range whole_range(const struct rmap_interval *interval)
{
    double low = ceil(fmax(interval->low, 0.0)), high = floor(fmin(interval->high, UINT32_MAX));
    struct whole_range range = {.empty = low > high, .flip = interval->outside};
    if (!range.empty) {
        range.least = (uint32_t)low;
        range.span = (uint32_t)(high - low);
    }
    return range;
}

/* inside: the verdict where least <= count <= least + span; outside: elsewhere. */
RMAP_WIDE static void choose(const uint32_t *restrict count, size_t n, uint32_t least,
                             uint32_t span, uint8_t inside, uint8_t outside,
                             uint8_t *restrict verdict)
{
    for (size_t i = 0; i < n; i++) {
        uint8_t mask = (uint8_t)(0 - (count[i] - least <= span));
        verdict[i] = (uint8_t)((mask & (inside ^ outside)) ^ outside);
    }
}

void rmap_compare_counts(const uint32_t *count, size_t n, const struct rmap_interval *interval,
                         uint8_t *verdict)
{
    struct whole_range range = whole_range(interval);
    uint8_t flip = range.flip ? RMAP_VERDICT_YES : RMAP_VERDICT_NO;
    if (range.empty)
        memset(verdict, flip, n);
    else
        choose(count, n, range.least, range.span, flip ^ RMAP_VERDICT_YES, flip, verdict);
}

void rmap_compare_bounds(const uint32_t *count, size_t n, const struct rmap_interval *interval,
                         uint8_t *verdict)
{
    struct whole_range range = whole_range(interval);
    uint8_t decided = range.least > 0 || range.empty ? RMAP_VERDICT_NO : RMAP_VERDICT_YES;
    uint8_t own = range.flip ? rmap_verdict_not(decided) : decided;
    if (range.empty)
        memset(verdict, own, n);
    else if (range.least > 0) /* decided where there are fewer */
        choose(count, n, 0, range.least - 1, own, RMAP_VERDICT_OPEN, verdict);
    else
        choose(count, n, 0, range.span, own, RMAP_VERDICT_OPEN, verdict);
}

RMAP_WIDE void rmap_compare_numbers(const double *restrict number, size_t n,
                                    const struct rmap_interval *interval, uint8_t *restrict verdict)
{
    double low = interval->low, high = interval->high;
    if (interval->outside)
        for (size_t i = 0; i < n; i++)
            verdict[i] = (uint8_t)(((number[i] < low) | (number[i] > high)) * RMAP_VERDICT_YES);
    else
        for (size_t i = 0; i < n; i++)
            verdict[i] = (uint8_t)(((number[i] >= low) & (number[i] <= high)) * RMAP_VERDICT_YES);
}

void rmap_counts_of_bytes(uint32_t *count, size_t n)
{
    const uint8_t *byte = (const uint8_t *)count;
    for (size_t i = n; i-- > 0;) /* a byte is read before its place is written */
        count[i] = byte[i];
}
