/* SPDX-License-Identifier: MIT
 *
 * Marks and counts, summed.
 */
#ifndef RMAP_COUNT_H
#define RMAP_COUNT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Entries of an array, as opposed to a pointer. */
#define RMAP_COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* How many of n marks, each 0 or 1, are 1. */
size_t rmap_count_ones(const uint8_t *mark, size_t n);

/* How many of n marks are this one. */
size_t rmap_count_equal(const uint8_t *mark, size_t n, uint8_t wanted);

/* Whether n counts add up to so much. */
bool rmap_sums_to(const uint32_t *count, size_t n, uint64_t wanted);

#endif
