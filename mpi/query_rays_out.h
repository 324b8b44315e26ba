/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query: listed, or written to a file.
 */
#ifndef RMAP_QUERY_RAYS_OUT_H
#define RMAP_QUERY_RAYS_OUT_H

#include "analysis/query.h"
#include "mpi/command.h"

/* RMAP_USAGE when the path names no kind that can be written, or something stands there. */
enum rmap_status rmap_query_rays_check(const char *path, bool force,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Rank 0. path NULL: on stdout, a line per ray (its id and its path in letters), or with --json
 * the array of rays. */
enum rmap_status rmap_query_rays_print(const struct rmap_context *context,
                                       const struct rmap_map *map, const struct rmap_portion *rays,
                                       const char *path, struct rmap_error *err) RMAP_MUST_USE;

/* Rank 0. What would be read; rays_wanted: with all columns of the rays that match. */
enum rmap_status rmap_query_explain(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_criterion *const *criterion, size_t n_criterion,
                                    bool rays_wanted, struct rmap_error *err) RMAP_MUST_USE;

#endif
