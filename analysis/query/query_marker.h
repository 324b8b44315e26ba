/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion match one criterion, by paths and columns as a scan finds them.
 */
#ifndef RMAP_QUERY_MARKER_H
#define RMAP_QUERY_MARKER_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"

/* One thread. Map and criterion (NULL: all rays match) are borrowed. more: columns that
 * rmap_query_marker_read may ask for. */
struct rmap_query_marker;
enum rmap_status rmap_query_marker_create(const struct rmap_map *map,
                                          const struct rmap_criterion *criterion,
                                          rmap_column_set more,
                                          struct rmap_query_marker **marker_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_marker_destroy(struct rmap_query_marker *marker); /* NULL is fine */

/* Takes a portion in hand. *n_ret: its rays, or 0 where its summary rules out that one matches: it
 * is not read. RMAP_FORMAT when stored rows do not fit together. */
enum rmap_status rmap_query_marker_enter(struct rmap_query_marker *marker, size_t portion,
                                         size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_query_outcomes_narrow, right after entering it. */
enum rmap_status rmap_query_marker_narrow(struct rmap_query_marker *marker, bool *is_narrow_ret,
                                          size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Of the portion in hand: (*match_ret)[i] = 1 or 0 for row i of /ray, the marker's until the next
 * call; *n_ret: how many are 1. Without a criterion NULL, and all; NULL and 0 of a portion that was
 * ruled out. RMAP_FORMAT. */
enum rmap_status rmap_query_marker_mark(struct rmap_query_marker *marker, uint8_t **match_ret,
                                        size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Columns of the portion in hand; it stays the same and gets what is read later. */
enum rmap_status rmap_query_marker_read(struct rmap_query_marker *marker, rmap_column_set columns,
                                        const struct rmap_portion **portion_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_cursor_weigh, of that portion. */
enum rmap_status rmap_query_marker_weigh(struct rmap_query_marker *marker, bool *are_one_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* What reads that portion, which it has entered. */
enum rmap_status rmap_query_marker_cursor(struct rmap_query_marker *marker,
                                          struct rmap_cursor **cursor_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_query_outcomes_nbytes. */
uint64_t rmap_query_marker_nbytes(const struct rmap_query_marker *marker);

#endif
