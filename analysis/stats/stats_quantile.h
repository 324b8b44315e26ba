/* SPDX-License-Identifier: MIT
 *
 * Quantiles: the least value with at least a share p of the flux at or below it, and their errors.
 * The fine histogram says in which of its bins a share is reached; with the readings in memory,
 * those of the bin are listed and tell it exactly; without, it is interpolated.
 */
#ifndef RMAP_STATS_QUANTILE_H
#define RMAP_STATS_QUANTILE_H

#include "analysis/stats/stats.h"

/* Fills the quantiles of every group; see stats_quantile.c. */
enum rmap_status rmap_stats_find_quantiles(struct rmap_stats *stats,
                                           const struct rmap_stats_gathered *gathered,
                                           const struct rmap_stats_sums *sums,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif
