/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query: listed, or written to a file.
 */
#ifndef RMAP_QUERY_RAYS_OUT_H
#define RMAP_QUERY_RAYS_OUT_H

#include <stdbool.h>

#include "analysis/query/query.h"
#include "mpi/answer/ray_table_out.h"
#include "mpi/command/command.h"
#include "mpi/scan/ray_stream.h"

/* RMAP_USAGE when the path names no kind that can be written, or something stands there. */
enum rmap_status rmap_query_rays_check(const char *path, bool force,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* True for the name of a file of rays: NAME.csv, NAME.json, NAME.vtp, NAME.h5, NAME.tm25ray or
 * NAME.mcpl, in any case. */
bool rmap_query_rays_named(const char *path);
bool rmap_query_rays_are_tables(const char *path); /* NAME.h5 */
bool rmap_query_rays_are_files(const char *path);  /* NAME.tm25ray or NAME.mcpl */

/* Where the rays of an answer go, one after another; all of it on rank 0. No path: on stdout, a
 * line per ray (its id and its path in letters), or with --json the array of rays. */
struct rmap_rays_out;
enum rmap_status rmap_rays_out_begin(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_table_request *request,
                                     struct rmap_rays_out **out_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_rays_out_take(void *out, const struct rmap_streamed_ray *ray,
                                    struct rmap_error *err) RMAP_MUST_USE;
/* Ends the list, and says of a file what is in it. */
enum rmap_status rmap_rays_out_finish(struct rmap_rays_out *out,
                                      struct rmap_error *err) RMAP_MUST_USE;
/* Removes what was written of a file that was not finished: half an answer is none, and what had
 * its name keeps it. NULL is fine. */
void rmap_rays_out_destroy(struct rmap_rays_out *out);

/* Rank 0. What would be read; wanted: and these columns of the rays that match. */
enum rmap_status rmap_query_explain(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_criterion *const *criterion, size_t n_criterion,
                                    rmap_column_set wanted, struct rmap_error *err) RMAP_MUST_USE;

#endif
