/* SPDX-License-Identifier: MIT
 *
 * Readings of a few fine bins among many readings: windows over those bins, into which places are
 * compared many at once.
 */
#ifndef RMAP_STATS_WINDOWS_H
#define RMAP_STATS_WINDOWS_H

#include <stddef.h>
#include <stdint.h>

enum { RMAP_STATS_WINDOWS = 6 };

struct rmap_stats_windows {
    size_t n; /* 0: none, all places are of interest */
    uint16_t first[RMAP_STATS_WINDOWS], more[RMAP_STATS_WINDOWS]; /* bins [first, first + more] */
};

/* Over all n bins, in ascending order; near ones share a window. */
void rmap_stats_windows_over(struct rmap_stats_windows *windows, const uint16_t *bin, size_t n);

/* Lists which of n places may lie in a window, in their order: all that do. Returns how many. */
size_t rmap_stats_windows_pick(const struct rmap_stats_windows *windows, const uint16_t *place,
                               size_t n, uint32_t *picked);

#endif
