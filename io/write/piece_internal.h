/* SPDX-License-Identifier: MIT
 *
 * A piece being written, for the files that do it.
 */
#ifndef RMAP_PIECE_INTERNAL_H
#define RMAP_PIECE_INTERNAL_H

#include "io/hdf5/h5.h"
#include "io/write/journal_writer.h"
#include "io/write/piece_writer.h"

struct rmap_piece_writer {
    struct rmap_h5 h5;
    const struct rmap_run *run;
    struct rmap_piece_origin origin;
    char *directory, *temporary, *journal_path;
    const struct rmap_layout *layout;
    bool curved;           /* has /curve */
    int n_table, n_stream; /* of the layout, that the file has */
    int shard, number;
    hid_t set[RMAP_STREAM_MAX];
    struct rmap_chunk_entry *entry;
    size_t n_entry, cap_entry;
    size_t n_safe;                       /* entries that the journal has */
    size_t resting_nbytes;               /* stored since writing was last begun */
    int fd;                              /* of the file, for its lock, syncing and seal */
    struct rmap_journal_writer *journal; /* NULL before the first flush */
};

#endif
