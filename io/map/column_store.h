/* SPDX-License-Identifier: MIT
 *
 * Rows of a map's portions that stay in memory for later questions, as many as fit in a budget:
 * those that were asked for first. They are of decoded columns, or of what compact pieces store.
 * Nothing is ever let go, so that a question that reads more than fits still finds what the last
 * one left.
 */
#ifndef RMAP_COLUMN_STORE_H
#define RMAP_COLUMN_STORE_H

#include <stddef.h>

#include "base/status.h"
#include "compact/layout.h"
#include "portion/portion.h"

struct rmap_column_store;

/* Of these portions, for so many bytes at most. RMAP_SYSTEM. */
enum rmap_status rmap_column_store_create(size_t n_portion, size_t budget_nbytes,
                                          struct rmap_column_store **store_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_column_store_destroy(struct rmap_column_store *store);

/* What rows are of: column c is slot c, stream s of a compact piece RMAP_STORE_STREAM + s. */
enum {
    RMAP_STORE_STREAM = RMAP_COLUMN_COUNT,
    RMAP_STORE_SLOTS = RMAP_STORE_STREAM + RMAP_STREAM_MAX
};

/* The rows of a slot, borrowed until destroy, or NULL. Thread-safe. */
void *rmap_column_store_get(const struct rmap_column_store *store, size_t portion, int slot);

/* Copies the rows if there is room. Thread-safe; of two threads that offer the same, one wins. */
void rmap_column_store_offer(struct rmap_column_store *store, size_t portion, int slot,
                             const void *rows, size_t nbytes);

/* Bytes: what rows may take, what is set aside for them. */
size_t rmap_column_store_budget(const struct rmap_column_store *store);
size_t rmap_column_store_taken(const struct rmap_column_store *store);

/* Bytes of rows of columns, or of streams. */
size_t rmap_column_store_nbytes(const struct rmap_column_store *store, bool of_streams);

#endif
