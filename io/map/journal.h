/* SPDX-License-Identifier: MIT
 *
 * The journal of a piece in the making: what of it survives the death of its writer.
 *
 * Beside `.piece-KKKKK.h5.JOB.RESTART.HOST.PID.part` (HDF5, never opened with HDF5 before it is
 * finished) stands a plain file with `.journal` for `.part`. It only grows, little-endian:
 *
 *   record   u32 type, u32 bytes of the payload, payload
 *   HEADER   struct rmap_journal_header; first record of the file
 *   CHUNK    rows of /chunk (map_format.h), the fields of a row one after the other
 *   TAIL     u32 stream, u32 rows, u64 first row in the piece, raw rows: what is in no stored chunk
 *            and in no TAIL before
 *   PORTION  rows of /portion as a piece has them, the fields of a row one after the other
 *   COMMIT   u64 portions, u64 rows per stored table, u64 XXH3-64 of all bytes since the last
 *            COMMIT, seeded with that one's hash
 *
 * What lies before a COMMIT that holds is part of the map; stored chunks were synced before it was
 * written. Rows from the last full chunk on come from TAIL records.
 */
#ifndef RMAP_JOURNAL_H
#define RMAP_JOURNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/map/map_content.h"
#include "io/map/map_directory.h"

#define RMAP_JOURNAL_MAGIC   "rmapjrnl"
#define RMAP_JOURNAL_VERSION 1

/* format_major: what rows of portions count. The map's format is not told: who reads a journal has
 * opened its map. */
enum { RMAP_JOURNAL_STRAIGHT = 2, RMAP_JOURNAL_CURVED = 4 /* with /curve */ };

enum rmap_journal_record {
    RMAP_JOURNAL_HEADER = 1,
    RMAP_JOURNAL_CHUNK,
    RMAP_JOURNAL_TAIL,
    RMAP_JOURNAL_PORTION,
    RMAP_JOURNAL_COMMIT
};

/* As in the file: no padding, text ends with 0. */
struct rmap_journal_header {
    char magic[8];
    uint32_t version;                      /* RMAP_JOURNAL_VERSION */
    uint32_t format_major, format_minor;   /* as above, 0 */
    uint32_t chunk_nbytes, portion_nbytes; /* of a row in CHUNK, in PORTION */
    uint32_t encoding;                     /* enum rmap_encoding */
    uint32_t mode;                         /* enum rmap_colour_mode */
    uint32_t n_channel;
    int32_t shard, number;
    uint64_t seed;
    char scene_digest[40]; /* as in struct rmap_piece_origin */
    char space_digest[40];
    char isa[32];
    char embree_version[32];
};
_Static_assert(sizeof(struct rmap_journal_header) == 200, "the header is its bytes in the file");

/* Rows of one TAIL record that are in no stored chunk. */
struct rmap_journal_tail {
    uint64_t first_row; /* in the piece */
    uint64_t offset;    /* of the raw rows in the journal */
    uint32_t n_row;
    uint32_t stream;
};

/* What a journal commits. */
struct rmap_journal {
    struct rmap_journal_header header;
    const struct rmap_layout *layout;
    uint64_t n_row[RMAP_STORED_TABLE_MAX];
    struct rmap_chunk_entry *entry; /* by stream and index: all full chunks of every stream */
    size_t n_entry;
    struct rmap_portion_info *portion; /* in the order of their rows; shard and piece are not set */
    size_t n_portion;
    struct rmap_journal_tail *tail; /* by stream and row: all rows behind the full chunks */
    size_t n_tail;
    uint64_t nbytes;         /* of the file, committed */
    uint64_t nbytes_dropped; /* behind the last commit that holds */
    bool other_version;      /* what read could not tell: another raymap can */
};

/* Reads up to the last commit that holds. Everything in it is checked: chunks, tails and portions
 * tile the rows that the commit states. Without any commit n_portion is 0 and layout NULL.
 * RMAP_FORMAT: no journal, of another version, or its numbers contradict each other; RMAP_SYSTEM.
 * The caller calls rmap_journal_fini in any case. */
enum rmap_status rmap_journal_read(const char *path, struct rmap_journal *journal,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_journal_fini(struct rmap_journal *journal);

/* Appends what the journal commits to a content, as an open piece; rows of its tails are read from
 * the journal again. name: of the .part file, from the map's directory on. part_nbytes: its size.
 * RMAP_FORMAT when the journal ends before its tails do; RMAP_SYSTEM. The content is unchanged
 * then. A journal without a commit appends nothing. */
enum rmap_status rmap_journal_content(const struct rmap_journal *journal, const char *journal_path,
                                      const char *name, uint64_t part_nbytes,
                                      struct rmap_map_content *content,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Where the piece belongs. */
void rmap_journal_origin(const struct rmap_journal *journal, struct rmap_piece_origin *origin);

/* All of that for an unfinished piece (rmap_map_list_leftovers), as rmap_piece_read does for a
 * finished one. *committed_ret says whether it commits anything; the content is unchanged and the
 * origin not set if not. RMAP_FORMAT also when the journal's .part is missing. */
enum rmap_status rmap_open_piece_read(const char *map_path, const struct rmap_leftover *leftover,
                                      struct rmap_map_content *content,
                                      struct rmap_piece_origin *origin_ret, bool *committed_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
