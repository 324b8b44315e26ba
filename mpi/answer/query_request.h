/* SPDX-License-Identifier: MIT
 *
 * What `raymap query` is asked for.
 */
#ifndef RMAP_QUERY_REQUEST_H
#define RMAP_QUERY_REQUEST_H

#include "mpi/answer/stats_options.h"
#include "mpi/command/arguments.h"
#include "mpi/command/asked.h"
#include "mpi/command/until.h"
#include "mpi/scan/ray_sample.h"
#include "mpi/scan/scan.h"

struct rmap_query_request {
    const char *map_path, *output_path, *columns, *at;
    const char *of;                  /* what the greatest values are of, with `top` */
    uint64_t limit;                  /* UINT64_MAX: all */
    uint64_t top;                    /* 0: not asked for */
    struct rmap_sample_order sample; /* most 0: none */
    enum rmap_deal_kind deal;
    enum rmap_encoding encoding; /* RMAP_ENCODING_COUNT: not given */
    bool map;                    /* the answer is a ray map */
    bool count, explain, force;
    bool listed; /* the answer is a list, of one criterion too */
    enum rmap_stats_by by;
    struct rmap_until until;
    struct rmap_asked asked;
    const char **text; /* criteria as they were given, borrowed */
};

/* All but the criteria. RMAP_USAGE; rmap_query_request_fini whatever happened. */
enum rmap_status rmap_query_request_read(const struct rmap_arguments *given,
                                         struct rmap_query_request *request,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The criteria, of operands, --where and --criteria. RMAP_USAGE, or as
 * rmap_asked_load. */
enum rmap_status rmap_query_request_criteria(const struct rmap_context *context,
                                             const struct rmap_arguments *given,
                                             struct rmap_query_request *request,
                                             struct rmap_error *err) RMAP_MUST_USE;

void rmap_query_request_fini(struct rmap_query_request *request); /* zeroed: fine */

#endif
