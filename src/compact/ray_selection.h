/* SPDX-License-Identifier: MIT
 *
 * Some rays of a portion as the rows of a portion of those alone, so that no other ray need be
 * traced again: what predictions do not depend on is left out of the lanes, and nothing is decoded.
 */
#ifndef RMAP_COMPACT_RAY_SELECTION_H
#define RMAP_COMPACT_RAY_SELECTION_H

#include "compact/layout.h"
#include "compact/model.h"

struct rmap_path_table;
struct rmap_compact_summary;

/* One per thread; the model is borrowed. */
struct rmap_compact_selection;
enum rmap_status rmap_compact_selection_create(const struct rmap_compact_model *model,
                                               struct rmap_compact_selection **selection_ret,
                                               struct rmap_error *err) RMAP_MUST_USE;
void rmap_compact_selection_destroy(struct rmap_compact_selection *selection); /* NULL is fine */

/* Streams of the portion that selecting for these columns takes, by its header. */
uint64_t rmap_compact_selection_streams(rmap_column_set columns,
                                        const struct rmap_compact_summary *header);

/* ray: [n], n > 0, rows of /ray, ascending. rows, n_row: the portion's, as for decoding; of curved
 * segments nothing is taken. *selected_ret, selected_row: theirs, as rmap_compact_decode takes
 * them for `columns`, and no others; the rows are the selection's until the next call. RMAP_FORMAT
 * when rows do not fit together. */
enum rmap_status
rmap_compact_select(struct rmap_compact_selection *selection, const struct rmap_path_table *table,
                    const struct rmap_rows *rows, const size_t n_row[RMAP_TABLE_COUNT],
                    rmap_column_set columns, const uint32_t *ray, size_t n,
                    const struct rmap_rows **selected_ret, size_t selected_row[RMAP_TABLE_COUNT],
                    struct rmap_error *err) RMAP_MUST_USE;

#endif
