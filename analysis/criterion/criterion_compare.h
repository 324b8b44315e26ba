/* SPDX-License-Identifier: MIT
 *
 * Outcomes from what a test found of each ray, without a branch per ray.
 */
#ifndef RMAP_CRITERION_COMPARE_H
#define RMAP_CRITERION_COMPARE_H

#include "analysis/criterion/criterion_evaluate.h"

/* outcome: [n], enum rmap_outcome, where the interval holds a count that lies between least and
 * most [n]; these are the same where it is known. least NULL: 0. */
void rmap_compare_counts(const uint32_t *least, const uint32_t *most, size_t n,
                         const struct rmap_interval *interval, uint8_t *outcome);

void rmap_compare_numbers(const double *number, size_t n, const struct rmap_interval *interval,
                          uint8_t *outcome);

#endif
