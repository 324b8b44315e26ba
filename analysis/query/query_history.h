/* SPDX-License-Identifier: MIT
 *
 * What the history index tells of the portions of a map, for the criteria of one scan: outcomes
 * without a column being read, open where measured numbers decide.
 */
#ifndef RMAP_QUERY_HISTORY_H
#define RMAP_QUERY_HISTORY_H

#include "analysis/criterion/criterion_evaluate.h"
#include "history/history_index.h"
#include "io/map/map_reader.h"

struct rmap_query_history;

/* All borrowed. One thread. */
enum rmap_status rmap_query_history_create(const struct rmap_map *map,
                                           const struct rmap_criterion *const *criterion,
                                           size_t n_criterion,
                                           struct rmap_query_history **history_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_history_destroy(struct rmap_query_history *history);

/* Takes a portion in hand. *view_ret: borrowed until the next, or NULL: the index does not tell of
 * this portion. */
enum rmap_status rmap_query_history_enter(struct rmap_query_history *history, size_t portion,
                                          const struct rmap_history_view **view_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* PATHS: outcomes of criterion c per path of the portion: outcome [n_path]. ROWS: per ray: outcome
 * [n_ray]. */
enum rmap_status rmap_query_history_evaluate(struct rmap_query_history *history, size_t c,
                                             uint8_t *outcome,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Discrete columns of the portion in hand; *rows_ret is the same until the next enter. */
enum rmap_status rmap_query_history_unfold(struct rmap_query_history *history,
                                           rmap_column_set columns,
                                           const struct rmap_portion **rows_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* The discrete columns that its rays are known by. PATHS: those of the dictionary, where ray i is
 * row view->path_row[view->path[i]], and first_row[table] [its rows] says where its segments and
 * registrations begin. ROWS: unfolded, first_row NULL. */
struct rmap_known_rows {
    const struct rmap_portion *portion;
    const size_t *first_row[RMAP_TABLE_HISTORY_COUNT];
};
enum rmap_status rmap_query_history_know(struct rmap_query_history *history,
                                         rmap_column_set columns, struct rmap_known_rows *known,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Bytes of the index that were read so far. */
uint64_t rmap_query_history_nbytes(const struct rmap_query_history *history);

#endif
