/* SPDX-License-Identifier: MIT
 *
 * Agreement on errors: a rank that fails goes on to the next agreement point, and everyone leaves
 * it the same way.
 */
#ifndef RMAP_AGREE_H
#define RMAP_AGREE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "mpi/parallel/context.h"

/* Collective. `mine` is this rank's status and err its detail. When any rank failed, returns the
 * status of the lowest rank that did, with its text in every rank's err; else RMAP_OK. */
enum rmap_status rmap_agree(const struct rmap_context *context, enum rmap_status mine,
                            struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The same, where some ranks come long before others: they sleep, and leave the cores
 * to those that work. */
enum rmap_status rmap_agree_patiently(const struct rmap_context *context, enum rmap_status mine,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Turns an MPI return code into RMAP_SYSTEM with MPI's text. */
enum rmap_status rmap_mpi_check(int code, const char *call, struct rmap_error *err) RMAP_MUST_USE;

/* For use with RMAP_TRY: RMAP_TRY(RMAP_MPI(MPI_Barrier(comm))) */
#define RMAP_MPI(call) rmap_mpi_check((call), #call, err)

/* Collective. Sends rank 0's bytes to every rank, in pieces that MPI's int counts hold. On the
 * other ranks *blob is allocated (rmap_free). Agrees before it returns. */
enum rmap_status rmap_broadcast_blob(const struct rmap_context *context, uint8_t **blob,
                                     size_t *nbytes, struct rmap_error *err) RMAP_MUST_USE;

#endif
