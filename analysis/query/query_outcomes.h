/* SPDX-License-Identifier: MIT
 *
 * What several criteria say of the rays of a portion, by their paths where these tell, and of the
 * rays that they leave open, by columns: each is read when a test, or the sums over rays that
 * matched, first ask for it. Criteria share what was read and found.
 */
#ifndef RMAP_QUERY_OUTCOMES_H
#define RMAP_QUERY_OUTCOMES_H

#include "analysis/query/query.h"

struct rmap_query_outcomes;

/* The map, the criteria and their array are borrowed. One thread. more: columns that
 * rmap_query_outcomes_read may ask for beside those of the criteria. */
enum rmap_status rmap_query_outcomes_create(const struct rmap_map *map,
                                            const struct rmap_criterion *const *criterion,
                                            size_t n_criterion, rmap_column_set more,
                                            struct rmap_query_outcomes **outcomes_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_outcomes_destroy(struct rmap_query_outcomes *outcomes);

/* Takes a portion in hand. */
enum rmap_status rmap_query_outcomes_enter(struct rmap_query_outcomes *outcomes, size_t portion,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Leaves the rays that arrive of the portion in hand, of which nothing was read yet, as
 * rmap_cursor_narrow: *n_ray_ret of them, or all of its rays. */
enum rmap_status rmap_query_outcomes_narrow(struct rmap_query_outcomes *outcomes,
                                            bool *is_narrow_ret, size_t *n_ray_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Adds the rays that match a criterion to its count, some of them only when it is settled. */
enum rmap_status rmap_query_outcomes_add(struct rmap_query_outcomes *outcomes, size_t c,
                                         struct rmap_count *count,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* The same where all rays of the piece but those with paths of their own were counted before. */
enum rmap_status rmap_query_outcomes_add_own(struct rmap_query_outcomes *outcomes, size_t c,
                                             struct rmap_error *err) RMAP_MUST_USE;

void rmap_query_outcomes_settle(struct rmap_query_outcomes *outcomes, struct rmap_count *count);

/* Marks them: match[i] = 1 or 0 for row i of /ray. */
enum rmap_status rmap_query_outcomes_mark(struct rmap_query_outcomes *outcomes, size_t c,
                                          uint8_t *match, struct rmap_error *err) RMAP_MUST_USE;

/* Columns of the portion in hand, of those of the criteria and of `more`. The portion is the same
 * until the next enter: it gets what is read later. */
enum rmap_status rmap_query_outcomes_read(struct rmap_query_outcomes *outcomes,
                                          rmap_column_set columns,
                                          const struct rmap_portion **portion_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_cursor_weigh. */
enum rmap_status rmap_query_outcomes_weigh(struct rmap_query_outcomes *outcomes, bool *are_one_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* What reads the portion in hand, which it has entered. */
enum rmap_status rmap_query_outcomes_cursor(struct rmap_query_outcomes *outcomes,
                                            struct rmap_cursor **cursor_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* What is left of a criterion in the portion in hand: rays that paths leave open, those that what
 * stands beside them does, too, those that are not ruled out then, all. Paths and places are read.
 * *told_ret: false where paths do not tell. */
struct rmap_query_outlook {
    uint64_t n_open, n_left, n_possible, n_ray;
};
enum rmap_status rmap_query_outcomes_foresee(struct rmap_query_outcomes *outcomes, size_t c,
                                             struct rmap_query_outlook *outlook, bool *told_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Stored bytes of what was read so far. */
uint64_t rmap_query_outcomes_nbytes(const struct rmap_query_outcomes *outcomes);

#endif
