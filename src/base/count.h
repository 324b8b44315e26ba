/* SPDX-License-Identifier: MIT
 *
 * Marks counted.
 */
#ifndef RMAP_COUNT_H
#define RMAP_COUNT_H

#include <stddef.h>
#include <stdint.h>

/* How many of n marks, each 0 or 1, are 1. */
size_t rmap_count_ones(const uint8_t *mark, size_t n);

#endif
