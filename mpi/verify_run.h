/* SPDX-License-Identifier: MIT
 *
 * Verifying a map on all ranks and threads.
 */
#ifndef RMAP_VERIFY_RUN_H
#define RMAP_VERIFY_RUN_H

#include "io/verify.h"
#include "mpi/command.h"

/* What was looked at, found or not. */
struct rmap_verified {
    uint64_t pieces, chunks, portions, rays, segments, bytes;
    double seconds;
};

/* Collective. Opens the map on every rank and looks at all of it. On rank 0, *findings (zeroed by
 * the caller, who finishes them) are those of all ranks in a stable order, the same for any number
 * of ranks and threads. The flags of the verification are the same on every rank. */
enum rmap_status rmap_verify_run(const struct rmap_context *context, const char *path,
                                 struct rmap_verification **verification_ret,
                                 struct rmap_findings *findings, struct rmap_verified *verified,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
