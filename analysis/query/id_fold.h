/* SPDX-License-Identifier: MIT
 *
 * The ids of all matching rays as a fold (fold.h): its state is a struct rmap_id_set, settled once
 * the fold has run. context: NULL.
 */
#ifndef RMAP_ID_FOLD_H
#define RMAP_ID_FOLD_H

#include "analysis/query/fold.h"

extern const struct rmap_fold_kind rmap_id_fold_kind;

#endif
