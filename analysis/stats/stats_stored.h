/* SPDX-License-Identifier: MIT
 *
 * Readings that are stored columns, of rays of weight 1: picked from there, by source.
 */
#ifndef RMAP_STATS_STORED_H
#define RMAP_STATS_STORED_H

#include "analysis/stats/stats_block.h"

/* The matching rays' values of the columns [n_ray], to reader->into where there is such memory,
 * else reader->arranged; where all match and are of one source, they stay where they are. The
 * block's runs are reader->run; there is room in all of these. source: of all rays, or -1: then
 * `of` is that of each [n_ray]. False: not all values
 * are numbers, and the block is none. */
bool rmap_stats_read_stored(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                            const struct rmap_matched *rays, int32_t source, const int32_t *of,
                            const double *const *column, struct rmap_stats_block *block);

#endif
