/* SPDX-License-Identifier: MIT
 *
 * Rows of tables as a journal carries them: the fields of map_format.h one after the other.
 */
#ifndef RMAP_JOURNAL_FORMAT_H
#define RMAP_JOURNAL_FORMAT_H

#include "io/map/journal.h"
#include "io/map/map_format.h"

struct rmap_journal_record_head {
    uint32_t type, nbytes;
};

/* Payload of TAIL before its rows. */
struct rmap_journal_tail_head {
    uint32_t stream, n_row;
    uint64_t first_row;
};

/* Payload of COMMIT: portions, rows of as many stored tables as the format has, hash. */
static inline size_t rmap_journal_commit_nbytes(bool curved)
{
    return 8 * (2 + rmap_format_n_table(curved));
}

_Static_assert(sizeof(struct rmap_journal_record_head) == 8, "bytes of the file");
_Static_assert(sizeof(struct rmap_journal_tail_head) == 16, "bytes of the file");

/* Bytes of a packed row. */
size_t rmap_journal_row_nbytes(struct rmap_field_table table);
void rmap_journal_row_pack(struct rmap_field_table table, const void *row, uint8_t *packed);
void rmap_journal_row_unpack(struct rmap_field_table table, const uint8_t *packed, void *row);

#endif
