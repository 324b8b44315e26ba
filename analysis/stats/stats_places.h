/* SPDX-License-Identifier: MIT
 *
 * Which bin of the fine histogram a reading falls into. Bins are told from a product, many at once,
 * and one by one where rounding could matter: within a hair's breadth of an edge.
 */
#ifndef RMAP_STATS_PLACES_H
#define RMAP_STATS_PLACES_H

#include "analysis/stats/stats_sums.h"

/* Bin of a value of a quantity. Where cells of the histogram are made of fine bins
 * (plan->n_fine_per_cell): one of its cell. */
size_t rmap_stats_fine(const struct rmap_stats_plan *plan, size_t quantity, double value);

/* The same of n values, all within the range that the plan was made for. */
void rmap_stats_fine_places(const struct rmap_stats_plan *plan, size_t quantity,
                            const double *value, size_t n, uint16_t *place);

/* Cell of a value of the only quantity, or n_cell + RMAP_STATS_BELOW or RMAP_STATS_ABOVE. */
size_t rmap_stats_cell_at(const struct rmap_stats_plan *plan, double value);

/* Cell of reading k of a block; of two quantities, n_cell + RMAP_STATS_ABOVE is outside. */
size_t rmap_stats_cell_of(const struct rmap_stats_plan *plan, const struct rmap_stats_block *block,
                          size_t k);

/* Adds the fine bins of cells up, where cells are made of them. */
void rmap_stats_cells_from_fine(const struct rmap_stats_plan *plan, const uint32_t *fine,
                                double *cell);

#endif
