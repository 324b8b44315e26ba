/* SPDX-License-Identifier: MIT
 *
 * The counts of a query whose criterion speaks of receivers: a kind of fold (fold.h).
 */
#ifndef RMAP_OVERLAY_COUNT_H
#define RMAP_OVERLAY_COUNT_H

#include "analysis/query/fold.h"
#include "analysis/query/query.h"

/* Context: the map. The state is a struct rmap_overlay_count. */
extern const struct rmap_fold_kind rmap_overlay_count_kind;

struct rmap_overlay_count {
    size_t n_source;
    struct rmap_count count; /* rays, segments and weights alone */
};

#define RMAP_OVERLAY_COUNT_COLUMNS                                                                 \
    (RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |                         \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count))

#endif
