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

/* The same of counts that lie between these; neither here nor there: open. least: NULL stands for
 * 0. */
RMAP_WIDE static void choose_between(const uint32_t *restrict least, const uint32_t *restrict most,
                                     size_t n, const struct whole_range *range, uint8_t inside,
                                     uint8_t outside, uint8_t *restrict outcome)
{
    const uint32_t low = range->least, span = range->span, high = low + span;
    for (size_t i = 0; i < n; i++) {
        const uint32_t from = least ? least[i] : 0;
        const uint8_t in = (uint8_t)(0 - ((from >= low) & (most[i] <= high)));
        const uint8_t out = (uint8_t)(0 - ((most[i] < low) | (from > high)));
        outcome[i] = (uint8_t)((in & inside) | (out & outside) | (~(in | out) & RMAP_OUTCOME_OPEN));
    }
}

void rmap_compare_counts(const uint32_t *least, const uint32_t *most, size_t n,
                         const struct rmap_interval *interval, uint8_t *outcome)
{
    const struct whole_range range = whole_range(interval);
    const uint8_t outside = range.flip ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
    const uint8_t inside = rmap_outcome_not(outside);
    if (range.empty)
        memset(outcome, outside, n);
    else if (least == most)
        choose(most, n, range.least, range.span, inside, outside, outcome);
    else
        choose_between(least, most, n, &range, inside, outside, outcome);
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
