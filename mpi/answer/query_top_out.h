/* SPDX-License-Identifier: MIT
 *
 * The rays with the greatest values of a quantity, as a list of both.
 */
#ifndef RMAP_QUERY_TOP_OUT_H
#define RMAP_QUERY_TOP_OUT_H

#include "mpi/scan/top_pick.h"

/* Rank 0. On stdout, one line per ray, or with --json one object. */
enum rmap_status rmap_query_top_print(const struct rmap_context *context,
                                      const struct rmap_top_question *question,
                                      const struct rmap_sample_ray *ray, size_t n,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
