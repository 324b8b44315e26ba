/* SPDX-License-Identifier: MIT
 *
 * Criteria on compact pieces: what paths decide is decided once for each path of a
 * piece's dictionary; rays that share one look it up, and those with paths of their own are
 * evaluated by themselves. No other ray is decoded.
 */
#ifndef RMAP_QUERY_KNOWN_H
#define RMAP_QUERY_KNOWN_H

#include "analysis/criterion/criterion_evaluate.h"
#include "analysis/query/query.h"

struct rmap_query_known;

/* Whether criteria of one scan are put to paths at all. */
bool rmap_query_known_tells(const struct rmap_map *map,
                            const struct rmap_criterion *const *criterion, size_t n_criterion);

/* All borrowed. One thread. *known_ret NULL: paths tell nothing. */
enum rmap_status rmap_query_known_create(const struct rmap_map *map,
                                         const struct rmap_criterion *const *criterion,
                                         size_t n_criterion, struct rmap_query_known **known_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_known_destroy(struct rmap_query_known *known); /* NULL is fine */

/* Takes the portion that the cursor has entered, or narrowed, in hand, with so many rays. */
void rmap_query_known_enter(struct rmap_query_known *known, struct rmap_cursor *cursor,
                            size_t portion, size_t n_ray);

/* Outcomes of criterion c: outcome [n_ray], some of which may be open. *is_told_ret: false where
 * paths decide nothing; the outcomes mean nothing then. */
enum rmap_status rmap_query_known_evaluate(struct rmap_query_known *known, size_t c,
                                           uint8_t *outcome, bool *is_told_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Counts the rays that match criterion c; they are in the counts after rmap_query_known_settle.
 * *is_counted_ret: false where paths leave a ray open, or tell nothing: nothing was counted. */
enum rmap_status rmap_query_known_add(struct rmap_query_known *known, size_t c,
                                      bool *is_counted_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The same of the rays with paths of their own alone, where their criterion is discrete and all
 * other rays of the piece were counted (analysis/query/query_pieces.h). */
enum rmap_status rmap_query_known_add_own(struct rmap_query_known *known, size_t c,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The same of a portion that was evaluated so, whatever decided those that were left open: its rays
 * with outcome YES. */
enum rmap_status rmap_query_known_count(struct rmap_query_known *known, size_t c,
                                        const uint8_t *outcome,
                                        struct rmap_error *err) RMAP_MUST_USE;

void rmap_query_known_settle(struct rmap_query_known *known, struct rmap_count *count);

#endif
