/* SPDX-License-Identifier: MIT
 *
 * Outcomes from what a test found of each ray, without a branch per ray.
 */
#ifndef RMAP_CRITERION_COMPARE_H
#define RMAP_CRITERION_COMPARE_H

#include "analysis/criterion/criterion_evaluate.h"

/* What a count says of the one that is asked for: that it is the same, or anything up to it, or
 * from another one up to it. */
enum rmap_certainty { RMAP_EXACTLY, RMAP_AT_MOST, RMAP_BETWEEN };

/* outcome: [n], enum rmap_outcome, where the interval holds count [n]. least: [n] of RMAP_BETWEEN.
 */
void rmap_compare_counts(const uint32_t *least, const uint32_t *count, size_t n,
                         const struct rmap_interval *interval, enum rmap_certainty certainty,
                         uint8_t *outcome);

void rmap_compare_numbers(const double *number, size_t n, const struct rmap_interval *interval,
                          uint8_t *outcome);

#endif
