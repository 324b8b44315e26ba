/* SPDX-License-Identifier: MIT
 *
 * Length of a ray's way inside media.
 */
#ifndef RMAP_PATH_IN_H
#define RMAP_PATH_IN_H

#include "analysis/criterion/criterion_tree.h"

#define RMAP_PATH_IN_COLUMNS                                                                       \
    (RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |                    \
     RMAP_COLUMN_BIT(RMAP_RAY_path_length) | RMAP_COLUMN_BIT(RMAP_RAY_start) |                     \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_event) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |                  \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_position))
/* Those that tell which rays were in none of the media: their length is 0. */
#define RMAP_PATH_IN_DISCRETE                                                                      \
    (RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium))

/* Of the ray in row `row` of /ray, whose segments begin at row `first` of /segment, in the scene's
 * unit, without a segment that leaves the scene. Curved segments have what the straight ones leave
 * of the ray's length: NaN where some are in the media and others are not. */
double rmap_path_length_in(const struct rmap_index_set *media, const struct rmap_portion *portion,
                           size_t row, size_t first);

/* Whether some of n segments from row `first` on is in them. */
bool rmap_path_is_in(const struct rmap_index_set *media, const struct rmap_portion *portion,
                     size_t first, size_t n);

#endif
