/* SPDX-License-Identifier: MIT
 *
 * The history index of a piece as a file beside it: shard-RRRRR/piece-KKKKK.history.h5, sealed like
 * a piece. docs/map.md has its datasets.
 */
#ifndef RMAP_HISTORY_FILE_H
#define RMAP_HISTORY_FILE_H

#include "history/history_index.h"
#include "io/map/map_reader.h"

#define RMAP_FILETYPE_HISTORY "raymap history"
#define RMAP_HISTORY_SUFFIX   ".history.h5" /* in place of ".h5" of its piece */

/* "MAP/shard-00000/piece-00000.history.h5"; rmap_free. NULL when memory is short. */
char *rmap_history_path(const char *map_path, const struct rmap_piece_info *piece);

/* Writes the file of a piece, in place of one that is there; durable when it returns. RMAP_SYSTEM.
 */
enum rmap_status rmap_history_file_write(const char *map_path, const struct rmap_piece_info *piece,
                                         const struct rmap_history_bytes *bytes,
                                         uint64_t *nbytes_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Opens one. RMAP_INPUT: there is none; RMAP_FORMAT: it is damaged, too new or none of ours. */
enum rmap_status rmap_history_file_open(const char *path, const struct rmap_history_limits *limits,
                                        struct rmap_history_index **index_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
