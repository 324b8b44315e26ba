/* SPDX-License-Identifier: MIT
 *
 * Opens a portion of an index: its bytes are taken as they are where that is possible, and checked
 * as far as memory safety takes.
 */
#ifndef RMAP_HISTORY_VIEW_H
#define RMAP_HISTORY_VIEW_H

#include "history/history_index.h"

/* RMAP_FORMAT when the portion's bytes are damaged; RMAP_SYSTEM. portion in [0, n_portion). */
enum rmap_status rmap_history_view_open(const struct rmap_history_index *index, size_t portion,
                                        struct rmap_history_view *view,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_history_view_fini(struct rmap_history_view *view);

/* Bytes of the block, and a copy of it into room for as many, aligned as rmap_alloc does. */
size_t rmap_history_made_nbytes(const struct rmap_history_view *view);
void rmap_history_made_copy(const struct rmap_history_view *view, struct rmap_history_made *to);

/* Opens the same portion of the same index from such a block, without reading or checking anything.
 * The view has it until the next open or fini, and may add to what it holds. RMAP_SYSTEM. */
enum rmap_status rmap_history_view_reopen(const struct rmap_history_index *index, size_t portion,
                                          struct rmap_history_made *made,
                                          struct rmap_history_view *view,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* ROWS: the same of registrations. wanted: [n_hit] bytes, 0 or 1. */
const uint64_t *rmap_history_mark_hits(const struct rmap_history_view *view, const uint8_t *wanted);

#endif
