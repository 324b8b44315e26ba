/* SPDX-License-Identifier: MIT
 *
 * Weight and flux below the edges of fine bins: sums to every so many of them, and on from there
 * when one is asked for, as few are. Sums of weights are exact (rmap_stats_rounded).
 */
#ifndef RMAP_STATS_LEVELS_H
#define RMAP_STATS_LEVELS_H

#include "analysis/stats/stats_sums.h"

/* Of one quantity. */
struct rmap_stats_levels {
    const struct rmap_stats_sums *sums; /* borrowed */
    size_t quantity, n_step;
    double *before; /* [n_class][n_step + 1] weight in the bins before every so many */
};

/* RMAP_SYSTEM. */
enum rmap_status rmap_stats_levels_init(struct rmap_stats_levels *levels,
                                        const struct rmap_stats_sums *sums, size_t quantity,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_levels_fini(struct rmap_stats_levels *levels);

/* Weight of a class in the bins before `bin`, 0 <= bin <= n_fine. */
double rmap_stats_levels_weight(const struct rmap_stats_levels *levels, size_t class, size_t bin);

/* The same of a group's flux. */
double rmap_stats_levels_flux(const struct rmap_stats_levels *levels, size_t group, size_t bin);

/* First bin at whose end the flux of a group is more than 0 and reaches the target; the last one
 * where none does. */
size_t rmap_stats_levels_bin(const struct rmap_stats_levels *levels, size_t group, double target);

#endif
