/* SPDX-License-Identifier: MIT
 *
 * Outcomes from what a test found of each ray, without a branch per ray.
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

/* inside: the outcome where least <= count <= least + span; outside: elsewhere. */
RMAP_WIDE static void choose(const uint32_t *restrict count, size_t n, uint32_t least,
                             uint32_t span, uint8_t inside, uint8_t outside,
                             uint8_t *restrict outcome)
{
    for (size_t i = 0; i < n; i++) {
        uint8_t mask = (uint8_t)(0 - (count[i] - least <= span));
        outcome[i] = (uint8_t)((mask & (inside ^ outside)) ^ outside);
    }
}

static void compare_exactly(const uint32_t *count, size_t n, const struct whole_range *range,
                            uint8_t *outcome)
{
    uint8_t flip = range->flip ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
    if (range->empty)
        memset(outcome, flip, n);
    else
        choose(count, n, range->least, range->span, flip ^ RMAP_OUTCOME_YES, flip, outcome);
}

/* The outcome where no count up to the one given, or every one, is in the range. */
static uint8_t decided(const struct whole_range *range)
{
    uint8_t own = range->least > 0 || range->empty ? RMAP_OUTCOME_NO : RMAP_OUTCOME_YES;
    return range->flip ? rmap_outcome_not(own) : own;
}

static void compare_at_most(const uint32_t *count, size_t n, const struct whole_range *range,
                            uint8_t *outcome)
{
    uint8_t own = decided(range);
    if (range->empty)
        memset(outcome, own, n);
    else if (range->least > 0) /* decided where there are fewer */
        choose(count, n, 0, range->least - 1, own, RMAP_OUTCOME_OPEN, outcome);
    else
        choose(count, n, 0, range->span, own, RMAP_OUTCOME_OPEN, outcome);
}

void rmap_compare_counts(const uint32_t *least, const uint32_t *count, size_t n,
                         const struct rmap_interval *interval, enum rmap_certainty certainty,
                         uint8_t *outcome)
{
    struct whole_range range = whole_range(interval);
    if (certainty == RMAP_EXACTLY)
        compare_exactly(count, n, &range, outcome);
    else if (certainty == RMAP_AT_MOST)
        compare_at_most(count, n, &range, outcome);
    else
        for (size_t i = 0; i < n; i++)
            outcome[i] = rmap_bounds_outcome(interval, least[i], count[i]);
}

RMAP_WIDE void rmap_compare_numbers(const double *restrict number, size_t n,
                                    const struct rmap_interval *interval, uint8_t *restrict outcome)
{
    double low = interval->low, high = interval->high;
    if (interval->outside)
        for (size_t i = 0; i < n; i++)
            outcome[i] = (uint8_t)(((number[i] < low) | (number[i] > high)) * RMAP_OUTCOME_YES);
    else
        for (size_t i = 0; i < n; i++)
            outcome[i] = (uint8_t)(((number[i] >= low) & (number[i] <= high)) * RMAP_OUTCOME_YES);
}
