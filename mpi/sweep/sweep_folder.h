/* SPDX-License-Identifier: MIT
 *
 * The folder of a sweep's results: the sweep that it is of, and a journal of rows for each group of
 * ranks.
 */
#ifndef RMAP_SWEEP_FOLDER_H
#define RMAP_SWEEP_FOLDER_H

#include "mpi/sweep/sweep_run.h"

/* On one rank. Makes the folder, or sees that it holds the same sweep, and locks it. RMAP_USAGE,
 * RMAP_INPUT. */
enum rmap_status rmap_sweep_folder_prepare(struct rmap_sweep_run *run,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Rows of all journals, into the table. */
enum rmap_status rmap_sweep_folder_rows(struct rmap_sweep_run *run,
                                        struct rmap_error *err) RMAP_MUST_USE;

struct rmap_sweep_journal {
    int file; /* descriptor; -1: none */
    double synced;
};
enum rmap_status rmap_sweep_journal_open(const struct rmap_sweep_run *run, int number,
                                         struct rmap_sweep_journal *journal,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_sweep_journal_commit(const struct rmap_sweep_run *run,
                                           struct rmap_sweep_journal *journal, uint64_t variant,
                                           struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_sweep_journal_close(const struct rmap_sweep_run *run,
                                          struct rmap_sweep_journal *journal,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
