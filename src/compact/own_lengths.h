/* SPDX-License-Identifier: MIT
 *
 * About how long the rays with paths of their own are: a byte each, behind the lanes of pool16.
 *
 * A length rounded down to a float has the bits b, which grow with it. Rows: the least b of the
 * portion, low and high half; a shift; then, two to a row, the codes (b - least) >> shift, each
 * below 256. So a code says between which two lengths its ray's lies, some per cent apart.
 */
#ifndef RMAP_COMPACT_OWN_LENGTHS_H
#define RMAP_COMPACT_OWN_LENGTHS_H

#include <stdbool.h>

#include "base/status.h"
#include "compact/layout.h"
#include "compact/path_sum.h"

/* Rows of pool16 that n rays take. */
static inline size_t rmap_own_length_rows(size_t n)
{
    return 3 + (n + 1) / 2;
}

/* Rows of n lengths, which may be anything, in room for them. False: some are none of a ray, and
 * the rows mean nothing. */
bool rmap_own_lengths_make(const double *length, size_t n, uint16_t *row);

/* The bounds of path length of a portion's own paths: sum [those], whose other numbers are NaN and
 * 0; its header says that they are there. RMAP_FORMAT where they are not. */
enum rmap_status rmap_own_lengths_read(const struct rmap_rows *rows, struct rmap_path_sum *sum,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
