/* SPDX-License-Identifier: MIT
 *
 * Outcomes on a portion of which the history index has the rows (RMAP_HISTORY_ROWS): tests are put
 * to the classes of segments and registrations, and the index counts the rows of those that pass.
 */
#ifndef RMAP_QUERY_ROWS_H
#define RMAP_QUERY_ROWS_H

#include "analysis/criterion/criterion_evaluate.h"
#include "history/history_index.h"

struct rmap_query_rows;

/* The criteria are borrowed. One thread. */
enum rmap_status rmap_query_rows_create(const struct rmap_criterion *const *criterion,
                                        size_t n_criterion, struct rmap_query_rows **rows_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_rows_destroy(struct rmap_query_rows *rows); /* NULL is fine */

/* Takes a piece in hand, which must outlive that. */
enum rmap_status rmap_query_rows_enter_piece(struct rmap_query_rows *rows,
                                             const struct rmap_history_index *index,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Takes a portion of it in hand: all borrowed. rays: its discrete columns, those that fetch, called
 * with the context, has made. */
void rmap_query_rows_enter(struct rmap_query_rows *rows, const struct rmap_history_view *view,
                           const struct rmap_portion *rays,
                           enum rmap_status (*fetch)(void *context, rmap_column_set columns,
                                                     struct rmap_error *err),
                           void *context);

/* outcome: [n_ray] of criterion c; evaluator as rmap_criterion_decide has it. */
enum rmap_status rmap_query_rows_evaluate(struct rmap_query_rows *rows, size_t c,
                                          struct rmap_evaluator *evaluator, uint8_t *outcome,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
