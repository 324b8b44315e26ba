/* SPDX-License-Identifier: MIT
 *
 * What `raymap compare` is asked for.
 */
#ifndef RMAP_COMPARE_REQUEST_H
#define RMAP_COMPARE_REQUEST_H

#include "analysis/compare/compare.h"
#include "mpi/command/arguments.h"

struct rmap_compare_request {
    const char *path[2]; /* [1]: the first one again where two criteria are compared */
    char **where, **of;
    size_t n_where, n_of;
    const char *range;
    uint64_t n_bin;
    unsigned kinds;
    const char *detector, *output_path;
    double significance;
    enum rmap_correction correction;
};

/* RMAP_USAGE; rmap_compare_request_fini whatever happened. */
enum rmap_status rmap_compare_request_read(const struct rmap_arguments *given,
                                           struct rmap_compare_request *request,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_compare_request_fini(struct rmap_compare_request *request);

#endif
