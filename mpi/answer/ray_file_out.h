/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query as a file of rays, which other programs and `type: ray_file` read.
 */
#ifndef RMAP_RAY_FILE_OUT_H
#define RMAP_RAY_FILE_OUT_H

#include "mpi/answer/ray_table_out.h"

bool rmap_ray_file_named(const char *path); /* NAME.tm25ray or NAME.mcpl */

/* request->at: a plane detector, each registration on which becomes a ray; NULL: rays as they end,
 * those that leave the scene from where they met something last. RMAP_INPUT for a detector that is
 * not there or has no places, and for what has no wavelengths in a format that needs them. */
struct rmap_ray_file_out;
enum rmap_status rmap_ray_file_out_begin(const struct rmap_map *map,
                                         const struct rmap_table_request *request,
                                         struct rmap_ray_file_out **out_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_ray_file_out_take(struct rmap_ray_file_out *out,
                                        const struct rmap_streamed_ray *ray,
                                        struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_ray_file_out_finish(struct rmap_ray_file_out *out,
                                          struct rmap_error *err) RMAP_MUST_USE;
uint64_t rmap_ray_file_out_count(const struct rmap_ray_file_out *out); /* rays written so far */
/* Removes what was not finished. NULL is fine. */
void rmap_ray_file_out_destroy(struct rmap_ray_file_out *out);

#endif
