/* SPDX-License-Identifier: MIT
 *
 * The history indexes of an open map: piece-KKKKK.history.h5 beside piece-KKKKK.h5, where it was
 * made (`raymap index`). Opened when first needed, let go again when many are.
 */
#ifndef RMAP_MAP_HISTORY_H
#define RMAP_MAP_HISTORY_H

#include "history/history_index.h"
#include "io/map/map_reader.h"

/* The index of a piece, to be given back by rmap_map_history_release with the piece's number; NULL,
 * with nothing to give back: it has none, or one that is damaged or belongs to other rays, so that
 * columns are to be read (verify tells why). Thread-safe. RMAP_SYSTEM alone. */
enum rmap_status rmap_map_history(const struct rmap_map *map, size_t piece,
                                  const struct rmap_history_index **index_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_history_release(const struct rmap_map *map, size_t piece);

/* Takes note that a portion of the index of a piece is damaged, so that its columns are read; the
 * map does so itself where the whole file is. Thread-safe. */
void rmap_map_history_blame(const struct rmap_map *map, size_t piece, const struct rmap_error *why);

/* What was noted first: the file, what is wrong with it, and the remedy; false: nothing, or it was
 * told. Afterwards nothing more is noted. */
bool rmap_map_history_damage(const struct rmap_map *map, struct rmap_error *why_ret);
void rmap_map_history_told(const struct rmap_map *map);

/* A portion in the hands of a reader, one after the other. Zeroed at first; one thread. */
struct rmap_history_reader {
    struct rmap_history_view view;
    struct rmap_history_made *borrowed; /* by the map */
    size_t portion;                     /* of the map */
    bool is_open;
    uint64_t nbytes; /* of indexes that were read so far */
};

/* Opens portion `at` of the index of a piece, `portion` of the map, after leaving the one before. A
 * map that keeps things in memory (rmap_map_keep) has what an earlier reader made of it. The index
 * is the reader's until it has left. Errors as rmap_history_view_open, with nothing open. */
enum rmap_status rmap_history_reader_enter(const struct rmap_map *map,
                                           const struct rmap_history_index *index, size_t at,
                                           size_t portion, struct rmap_history_reader *reader,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_history_reader_leave(const struct rmap_map *map, struct rmap_history_reader *reader);
void rmap_history_reader_fini(const struct rmap_map *map, struct rmap_history_reader *reader);

/* Makes the index of a piece from its columns, of the first `most` of its portions. tick: NULL, or
 * called with the rows of /ray and /segment of each portion once it is done. bytes: rmap_free both.
 */
enum rmap_status rmap_map_history_make(const struct rmap_map *map, size_t piece, size_t most,
                                       void (*tick)(void *context, uint64_t n_row), void *context,
                                       struct rmap_history_bytes *bytes,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Gives an open map the index of a piece that has none; it stays in memory until the map is closed.
 * The bytes are taken over, on success alone. */
enum rmap_status rmap_map_history_keep(const struct rmap_map *map, size_t piece,
                                       struct rmap_history_bytes *bytes,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Opens the file of a piece's index and compares it with the piece. RMAP_INPUT: there is none;
 * RMAP_FORMAT: it is damaged or of other rays. index_ret: NULL, or to be destroyed. */
enum rmap_status rmap_map_history_open(const struct rmap_map *map, size_t piece,
                                       struct rmap_history_index **index_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Pieces beside which the file of an index stands, and the bytes of these files. Opens none. */
enum rmap_status rmap_map_history_measure(const struct rmap_map *map, size_t *n_piece_ret,
                                          uint64_t *nbytes_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Those files, and how many of them are of no use to a query, which then reads columns. Opens each.
 */
struct rmap_history_survey {
    size_t n_piece;
    uint64_t nbytes;
    size_t n_unused;
    struct rmap_error why; /* of the first of these */
};
enum rmap_status rmap_map_history_survey(const struct rmap_map *map,
                                         struct rmap_history_survey *survey,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Checks every byte of the file of a piece's index, and that it is of the piece's rays. RMAP_INPUT:
 * there is none; RMAP_FORMAT says what is wrong. */
enum rmap_status rmap_map_history_check(const struct rmap_map *map, size_t piece,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* From now on columns that cursors decode, and portions of history indexes that questions open,
 * stay in memory until close, and are taken from there: in all, with the indexes that the map was
 * given before (rmap_map_history_keep), so many bytes at most. What does not fit, or has no memory,
 * is read again. Not while a cursor is in use. RMAP_SYSTEM; RMAP_USAGE when called again. */
enum rmap_status rmap_map_keep(struct rmap_map *map, size_t budget_nbytes,
                               struct rmap_error *err) RMAP_MUST_USE;

void rmap_map_kept(const struct rmap_map *map, struct rmap_map_kept *kept);

/* Points rows at those of these columns of a portion that are kept, which it returns: nobody writes
 * to them. And keeps a copy of those in rows, all of which are there, as far as there is room. Both
 * thread-safe. */
rmap_column_set rmap_map_borrow_columns(const struct rmap_map *map, size_t portion,
                                        rmap_column_set columns, struct rmap_portion *rows);
void rmap_map_keep_columns(const struct rmap_map *map, size_t portion, rmap_column_set columns,
                           const struct rmap_portion *rows);

#endif
