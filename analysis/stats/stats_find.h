/* SPDX-License-Identifier: MIT
 *
 * The readings in memory that belong to a search's lists, found by several threads.
 */
#ifndef RMAP_STATS_FIND_H
#define RMAP_STATS_FIND_H

#include "analysis/stats/stats_search.h"

/* The least and greatest of every list: where they are equal, nothing need be sorted. */
void rmap_stats_measure_lists(struct rmap_stats_search *search);

/* Fills the search's findings. RMAP_SYSTEM. */
enum rmap_status rmap_stats_find_items(struct rmap_stats_search *search,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
