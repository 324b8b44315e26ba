/* SPDX-License-Identifier: MIT
 *
 * Decoded portions of the pieces of a map, one after the other.
 */
#ifndef RMAP_MAP_CURSOR_H
#define RMAP_MAP_CURSOR_H

#include "compact/path_sum.h"
#include "compact/step_codes.h"
#include "io/map/map_reader.h"

/* A cursor keeps its last decoded chunks (at most 64 per column; as many as the disorder of blocks
 * in a shard makes useful), so reading portions in order decodes each chunk about once, also where
 * shards alternate. One thread at a time; any number of cursors. */
enum rmap_status rmap_cursor_create(const struct rmap_map *map, rmap_column_set columns,
                                    struct rmap_cursor **cursor_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_cursor_destroy(struct rmap_cursor *cursor);

/* Reads the cursor's columns of one portion into the cursor's own struct rmap_portion (the other
 * columns are NULL), valid until the next read. Checked on the way: counts add up to the rows of
 * the other tables, and sources, objects, media, detectors and stops exist in the scene.
 * RMAP_FORMAT names the piece, the damaged dataset and the chunk. */
enum rmap_status rmap_cursor_read(struct rmap_cursor *cursor, size_t portion,
                                  const struct rmap_portion **portion_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* The same in steps. enter takes a portion in hand: its rows are counted, all its columns NULL.
 * fetch adds columns to the struct that enter gave, where they are not there yet. `columns` of
 * rmap_cursor_create are those that fetch may ask for; of a compact piece the discrete ones
 * are decoded together, and those that rays are traced again for, all with them. Errors as above.
 */
enum rmap_status rmap_cursor_enter(struct rmap_cursor *cursor, size_t portion,
                                   const struct rmap_portion **portion_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_cursor_fetch(struct rmap_cursor *cursor, rmap_column_set columns,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Rays i of the portion in hand with mark[i] != 0 are of no interest: what `fetch` adds from now on
 * may be anything for them where rays are traced again. mark: [n_ray], borrowed as long. */
void rmap_cursor_pass_over(struct rmap_cursor *cursor, const uint8_t *mark);

/* Rays of the portion in hand alone, side by side, with those columns: those with mark[i] ==
 * wanted, mark [n_ray]; where all of them, and the columns, are among those selected last since the
 * portion was entered, these. Only they are traced again, where a column has them be. *ray_ret:
 * [its rays] their rows in the portion. *selected_ret: NULL where that would not be of use (a plain
 * piece; nothing need be traced again; there are none, or too many of them; a reader keeps columns;
 * points of curved segments are asked for), and what `fetch` gives must do. Both are valid until
 * the next call of the same kind: for columns that rmap_cursor_traced names, or for none of those.
 * Errors as of fetch. */
enum rmap_status rmap_cursor_select(struct rmap_cursor *cursor, const uint8_t *mark, uint8_t wanted,
                                    rmap_column_set columns,
                                    const struct rmap_portion **selected_ret,
                                    const uint32_t **ray_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Whether that may be of use for a portion at all. */
bool rmap_map_selects(const struct rmap_map *map, size_t portion, rmap_column_set columns);

/* Of a portion whose columns have all been decoded: which one stands otherwise beside its piece
 * (io/map/piece_columns.h); *differs_ret is RMAP_COLUMN_COUNT where none does. Errors as of fetch.
 */
enum rmap_status rmap_cursor_compare_beside(struct rmap_cursor *cursor,
                                            enum rmap_column *differs_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* *traced_ret: columns for which rays of the portion in hand are traced again. Errors as of fetch.
 */
enum rmap_status rmap_cursor_traced(struct rmap_cursor *cursor, rmap_column_set *traced_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* What tells something of these columns of the portion in hand though no ray is traced again: of
 * directions, RMAP_COLUMNS_ANGLES with places. After rmap_cursor_traced; nothing is read. */
rmap_column_set rmap_cursor_tells_of(const struct rmap_cursor *cursor, rmap_column_set columns);

/* Takes for the portion in hand those of its rays alone that arrive (src/compact/arrivals.h), all
 * of its registrations among their rows; nothing of it may have been read yet. Its rows are counted
 * again; of its columns, RMAP_COLUMNS_ARRIVAL may be fetched, nothing else.
 * *is_narrow_ret: false where the portion does not tell, or a reader keeps columns: it is as it
 * was. Errors as of fetch. */
enum rmap_status rmap_cursor_narrow(struct rmap_cursor *cursor, bool *is_narrow_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Of one whose paths were summed up: the references of its rays that arrive, as it says itself, or
 * NULL where it does not. Valid until the portion is narrowed, or while it is in hand. */
enum rmap_status rmap_cursor_arrivals(struct rmap_cursor *cursor, const uint32_t **path_ret,
                                      size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* *are_one_ret: all rays of the portion in hand weigh 1, as the header of a compact one tells;
 * false says nothing. Errors as of fetch. */
enum rmap_status rmap_cursor_weigh(struct rmap_cursor *cursor, bool *are_one_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Of the portion in hand, without decoding it, where it is compact, its rays weigh 1, and the one
 * in row i is first_ray + i. own_alone: `path` may be NULL. Errors as of fetch. */
enum rmap_status rmap_cursor_path_summary(struct rmap_cursor *cursor, bool own_alone,
                                          struct rmap_path_summary *paths,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Of one that was summed up so: what the piece's rays with each path have in common, as
 * rmap_map_path_sums. Valid while the portion is in hand. */
enum rmap_status rmap_cursor_path_sums(struct rmap_cursor *cursor,
                                       const struct rmap_path_sum **sum_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Of one that was summed up so, the rays with paths of their own, side by side in their order, with
 * the discrete columns and ids that `columns` names or an earlier call did, segment counts and
 * weights. The portion is the same one for every call. */
enum rmap_status rmap_cursor_own_paths(struct rmap_cursor *cursor, rmap_column_set columns,
                                       const struct rmap_portion **own_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Of one that was summed up with classes: those of the segments of these rays, in order, as rows of
 * the classes; other numbers may be there. Valid while the portion is in hand. */
struct rmap_own_steps {
    struct rmap_step_codes codes; /* with n_code > 0; else: */
    const uint32_t *class;        /* [n_own_segment] */
};
enum rmap_status rmap_cursor_own_steps(struct rmap_cursor *cursor, struct rmap_own_steps *steps,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Of one that was summed up so and says about how long these rays are: between which lengths each
 * lies, [n_own]; else NULL. Valid while the portion is in hand. */
enum rmap_status rmap_cursor_own_lengths(struct rmap_cursor *cursor,
                                         const struct rmap_path_sum **sum_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Bytes read from files so far. */
uint64_t rmap_cursor_nbytes(const struct rmap_cursor *cursor);

/* Stored bytes of the rows read so far, a chunk's bytes being shared out over its rows: the sum
 * is the same however portions are dealt to cursors, which makes it fit for `query`'s report. */
uint64_t rmap_cursor_nbytes_of_rows(const struct rmap_cursor *cursor);

#endif
