/* SPDX-License-Identifier: MIT
 *
 * What all ranks found, on rank 0.
 */
#ifndef RMAP_GATHER_FINDINGS_H
#define RMAP_GATHER_FINDINGS_H

#include "base/status.h"
#include "io/file/findings.h"
#include "mpi/parallel/context.h"

/* Collective. Rank 0's findings become those of all ranks, in a stable order. */
enum rmap_status rmap_gather_findings(const struct rmap_context *context,
                                      struct rmap_findings *findings,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
