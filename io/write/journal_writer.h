/* SPDX-License-Identifier: MIT
 *
 * Writing a journal: records are gathered in a batch, and a batch becomes a commit.
 */
#ifndef RMAP_JOURNAL_WRITER_H
#define RMAP_JOURNAL_WRITER_H

#include "io/map/journal.h"

/* Records of one commit. Zeroed: empty. The adding functions leave it as it was when they fail
 * (RMAP_SYSTEM: memory). */
struct rmap_journal_batch {
    uint8_t *data;
    size_t nbytes, cap;
};

void rmap_journal_batch_fini(struct rmap_journal_batch *batch);

enum rmap_status rmap_journal_add_chunks(struct rmap_journal_batch *batch,
                                         const struct rmap_chunk_entry *entry, size_t n,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_journal_add_portions(struct rmap_journal_batch *batch, bool curved,
                                           const struct rmap_portion_info *portion, size_t n,
                                           struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_journal_add_tail(struct rmap_journal_batch *batch, int stream,
                                       uint64_t first_row, size_t n_row, size_t row_nbytes,
                                       const void *rows, struct rmap_error *err) RMAP_MUST_USE;

struct rmap_journal_writer;

/* A new file with the header, whose magic, version and row sizes are set here, and the format
 * unless it says RMAP_JOURNAL_CURVED; nothing is synced before the first commit. RMAP_SYSTEM,
 * also when the file exists. */
enum rmap_status rmap_journal_create(const char *path, const struct rmap_journal_header *header,
                                     struct rmap_journal_writer **writer_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Appends the batch, after which n_row rows per stored table and n_portion portions stand, and
 * syncs the file: they are safe when this returns RMAP_OK. The batch is empty then. RMAP_SYSTEM:
 * the journal takes no more commits; earlier ones hold. */
enum rmap_status rmap_journal_commit(struct rmap_journal_writer *writer,
                                     struct rmap_journal_batch *batch,
                                     const uint64_t n_row[RMAP_STORED_TABLE_MAX],
                                     uint64_t n_portion, struct rmap_error *err) RMAP_MUST_USE;

/* Closes; the file stays. NULL is fine. */
void rmap_journal_writer_destroy(struct rmap_journal_writer *writer);

#endif
