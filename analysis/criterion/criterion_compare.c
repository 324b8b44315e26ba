/* SPDX-License-Identifier: MIT
 *
 * Verdicts from what a test found of each ray, without a branch per ray.
 */
#include "analysis/criterion/criterion_compare.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_evaluate.h"
#include "base/byte_set.h"
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

static void compare_exactly(const uint32_t *count, size_t n, const struct whole_range *range,
                            uint8_t *verdict)
{
    uint8_t flip = range->flip ? RMAP_VERDICT_YES : RMAP_VERDICT_NO;
    if (range->empty)
        memset(verdict, flip, n);
    else
        choose(count, n, range->least, range->span, flip ^ RMAP_VERDICT_YES, flip, verdict);
}

/* The verdict where no count up to the one given, or every one, is in the range. */
static uint8_t decided(const struct whole_range *range)
{
    uint8_t own = range->least > 0 || range->empty ? RMAP_VERDICT_NO : RMAP_VERDICT_YES;
    return range->flip ? rmap_verdict_not(own) : own;
}

static void compare_at_most(const uint32_t *count, size_t n, const struct whole_range *range,
                            uint8_t *verdict)
{
    uint8_t own = decided(range);
    if (range->empty)
        memset(verdict, own, n);
    else if (range->least > 0) /* decided where there are fewer */
        choose(count, n, 0, range->least - 1, own, RMAP_VERDICT_OPEN, verdict);
    else
        choose(count, n, 0, range->span, own, RMAP_VERDICT_OPEN, verdict);
}

void rmap_compare_counts(const uint32_t *count, size_t n, const struct rmap_interval *interval,
                         enum rmap_told told, uint8_t *verdict)
{
    struct whole_range range = whole_range(interval);
    if (told == RMAP_EXACTLY)
        compare_exactly(count, n, &range, verdict);
    else
        compare_at_most(count, n, &range, verdict);
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
