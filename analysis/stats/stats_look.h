/* SPDX-License-Identifier: MIT
 *
 * What the first look at readings finds out.
 */
#ifndef RMAP_STATS_LOOK_H
#define RMAP_STATS_LOOK_H

#include "analysis/stats/stats_gather.h"

void rmap_stats_range_merge(struct rmap_stats_range *into, const struct rmap_stats_range *from);

/* Adds a portion's readings to what is known, and to the ranges of their groups. */
void rmap_stats_look(struct rmap_stats_gathered *gathered, const struct rmap_stats_block *block);

#endif
