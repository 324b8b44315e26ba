/* SPDX-License-Identifier: MIT
 *
 * Verdicts from what a test found of each ray, without a branch per ray.
 */
#ifndef RMAP_CRITERION_COMPARE_H
#define RMAP_CRITERION_COMPARE_H

#include "analysis/criterion_tree.h"

/* verdict: [n], enum rmap_verdict, where the interval holds count [n]. */
void rmap_compare_counts(const uint32_t *count, size_t n, const struct rmap_interval *interval,
                         uint8_t *verdict);

/* The same where a count may be anything from 0 up to the one given. */
void rmap_compare_bounds(const uint32_t *count, size_t n, const struct rmap_interval *interval,
                         uint8_t *verdict);
void rmap_compare_numbers(const double *number, size_t n, const struct rmap_interval *interval,
                          uint8_t *verdict);

/* Counts [n] of the n bytes that their memory begins with. */
void rmap_counts_of_bytes(uint32_t *count, size_t n);

#endif
