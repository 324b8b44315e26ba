/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion a question picks: those that match a criterion, or those of a list of
 * ids; and those rays whole.
 */
#ifndef RMAP_QUERY_MARK_H
#define RMAP_QUERY_MARK_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"

/* Both are borrowed. */
struct rmap_pick {
    const struct rmap_criterion *criterion; /* NULL: every ray */
    const uint64_t *id;                     /* [n_id], ascending: of those; NULL: of all rays */
    size_t n_id;
    rmap_column_set columns; /* of the rays that are read, and their ids and counts; 0: all */
};
rmap_column_set rmap_pick_columns(const struct rmap_pick *pick);

/* One per thread; any number may read one map at a time. */
struct rmap_picker;
enum rmap_status rmap_picker_create(const struct rmap_map *map, const struct rmap_pick *pick,
                                    struct rmap_picker **picker_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_picker_destroy(struct rmap_picker *picker); /* NULL is fine */

/* Marks rays of a portion: match[i] = 1 or 0 for row i of /ray, valid until the next call; NULL
 * when it holds none that is picked. *n_ret: how many. Reads what deciding takes. RMAP_FORMAT. */
enum rmap_status rmap_picker_mark(struct rmap_picker *picker, size_t portion,
                                  const uint8_t **match_ret, size_t *n_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Ids of a portion's rays [rays of the portion], ascending; valid until the next call. */
enum rmap_status rmap_picker_ids(struct rmap_picker *picker, size_t portion,
                                 const uint64_t **id_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The marked rays of a portion, the pick's columns; match: [rays of the portion], n of them 1.
 * Borrowed until the next call. */
enum rmap_status rmap_picker_read(struct rmap_picker *picker, size_t portion, const uint8_t *match,
                                  size_t n, const struct rmap_portion **rays_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
