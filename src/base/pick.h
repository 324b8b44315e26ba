/* SPDX-License-Identifier: MIT
 *
 * Some of an array's numbers, in their order, without a branch per number.
 */
#ifndef RMAP_PICK_H
#define RMAP_PICK_H

#include <stddef.h>
#include <stdint.h>

/* `to` has room for this many more than are picked: what then stands there is undefined. */
enum { RMAP_PICK_MORE = 4 };

/* How many of match[k] are 1, not 0. */
size_t rmap_pick_count(const uint8_t *match, size_t n);

/* Those with match[k] 1, not 0; returns how many. */
size_t rmap_pick_matching(const double *value, const uint8_t *match, size_t n, double *to);

/* Those with of[k] == which; returns how many. */
size_t rmap_pick_of(const double *value, const int32_t *of, int32_t which, size_t n, double *to);

/* Those with of[k] == which, and the others; these may stand right behind those. Returns how many
 * those are. */
size_t rmap_pick_both(const double *value, const int32_t *of, int32_t which, size_t n, double *to,
                      double *others);

/* Those with of[k] == which and match[k] 1, not 0. */
size_t rmap_pick_matching_of(const double *value, const uint8_t *match, const int32_t *of,
                             int32_t which, size_t n, double *to);

#endif
