/* SPDX-License-Identifier: MIT
 *
 * One scan of a range of portions for several criteria: counts, and the matching rays if wanted.
 */
#ifndef RMAP_QUERY_H
#define RMAP_QUERY_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"

/* Exact sums over the rays that matched one criterion. */
struct rmap_count {
    uint64_t rays, segments;
    uint64_t portions_read, nbytes_read;
    double *source_weight;         /* [n_source] sum of w */
    double *source_weight_squared; /* [n_source] sum of w^2 */
};

enum rmap_status rmap_count_init(struct rmap_count *count, size_t n_source,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_count_fini(struct rmap_count *count);
void rmap_count_add(struct rmap_count *into, const struct rmap_count *from, size_t n_source);

/* Flux of the matched rays and its standard error (NaN where a source has fewer than 2 rays):
 * variance = sum over sources of (Phi/N)^2 N/(N-1) (sum w^2 - (sum w)^2/N). */
void rmap_count_flux(const struct rmap_count *count, const struct rmap_map *map, double *flux_ret,
                     double *standard_error_ret);

/* Columns that counting the rays of criteria may read. */
rmap_column_set rmap_query_columns(const struct rmap_criterion *const *criterion,
                                   size_t n_criterion);

/* One thread's scan, in as many ranges as it likes: what it reads and finds out of the map is kept
 * from range to range. The map, the criteria and their array are borrowed. */
struct rmap_query_scanner;
enum rmap_status rmap_query_scanner_create(const struct rmap_map *map,
                                           struct rmap_criterion *const *criterion,
                                           size_t n_criterion,
                                           struct rmap_query_scanner **scanner_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_query_scanner_destroy(struct rmap_query_scanner *scanner);

/* Rays of compact pieces that were counted before, but for those with paths of their own:
 * [n_criterion][n_piece] of rmap_query_pieces_count, borrowed. Nothing can be collected then. */
void rmap_query_scanner_set_counted(struct rmap_query_scanner *scanner, const uint8_t *counted);

/* Scans portions [first, last). count: [n_criterion], added to. collect: NULL, or where the rays
 * that match criterion 0 are appended (all columns), at most `limit` of them (UINT64_MAX: all); the
 * scan of criterion 0 then stops once it has them, and its count is that of the portions read until
 * then. RMAP_FORMAT when stored rows do not fit together. */
enum rmap_status rmap_query_scanner_scan(struct rmap_query_scanner *scanner, size_t first,
                                         size_t last, struct rmap_count *count,
                                         struct rmap_portion *collect, uint64_t limit,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* A scanner made for one range. Threads may scan ranges of their own at the same time. */
enum rmap_status rmap_query_scan(const struct rmap_map *map,
                                 struct rmap_criterion *const *criterion, size_t n_criterion,
                                 size_t first, size_t last, struct rmap_count *count,
                                 struct rmap_portion *collect, uint64_t limit,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
