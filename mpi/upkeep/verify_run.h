/* SPDX-License-Identifier: MIT
 *
 * Verifying a map on all ranks and threads.
 */
#ifndef RMAP_VERIFY_RUN_H
#define RMAP_VERIFY_RUN_H

#include "io/recovery/verify.h"
#include "mpi/command/command.h"

/* What was looked at, found or not. */
struct rmap_verified {
    uint64_t pieces, chunks, portions, rays, segments, bytes;
    double seconds;
};

struct rmap_verify_result {
    struct rmap_verification *verification; /* its flags are the same on every rank */
    struct rmap_findings findings;          /* rank 0: of all ranks, in a stable order */
    struct rmap_verified verified;
    struct rmap_tally
        *tally; /* rank 0: of all good portions of finished pieces; NULL without a map */
};

/* Collective. Opens the map on every rank and looks at all of it. Findings are the same for any
 * number of ranks and threads. The caller finishes the result, in any case. */
enum rmap_status rmap_verify_run(const struct rmap_context *context, const char *path,
                                 struct rmap_verify_result *result,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_verify_result_fini(struct rmap_verify_result *result);

#endif
