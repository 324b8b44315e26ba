/* SPDX-License-Identifier: MIT
 *
 * The columns that a map keeps beside its pieces, as `keep` and `info` tell of them.
 */
#ifndef RMAP_KEPT_COLUMNS_OUT_H
#define RMAP_KEPT_COLUMNS_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "io/map/piece_columns.h"

/* NULL: memory was short. */
json_t *rmap_kept_columns_json(const struct rmap_columns_survey *survey);

/* Lines of what is there; none where nothing is. */
void rmap_kept_columns_print(const struct rmap_columns_survey *survey, FILE *out);

#endif
