/* SPDX-License-Identifier: MIT
 *
 * Which rays of a decoded portion have numbers that their paths did not predict: who writes the
 * rows again need follow no others.
 */
#ifndef RMAP_COMPACT_UNPREDICTED_H
#define RMAP_COMPACT_UNPREDICTED_H

#include "compact/model.h"

/* Of lanes that are loaded, and looked at no further yet; of the portion's rows by their counts.
 * False: not known, since the portion is stored otherwise than this program does, or too many. */
bool rmap_unpredicted_list(const struct rmap_compact_model *model, const struct rmap_lane *lane,
                           const struct rmap_lane_header *header,
                           const struct rmap_portion *portion, struct rmap_unpredicted *list);

#endif
