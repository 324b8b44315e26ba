/* SPDX-License-Identifier: MIT
 *
 * The sums of all ranks as one.
 */
#include "mpi/parallel/tally_reduce.h"

#include "mpi/parallel/agree.h"

/* All sums are whole numbers far below 2^53, so adding them in any order is exact. */
enum rmap_status rmap_tally_reduce(const struct rmap_context *context, struct rmap_tally *tally,
                                   struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 24;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < tally->n_value; at += piece) {
        size_t n = tally->n_value - at < piece ? tally->n_value - at : piece;
        const void *from = context->rank == 0 ? MPI_IN_PLACE : tally->value + at;
        RMAP_TRY(RMAP_MPI(
            MPI_Reduce(from, tally->value + at, (int)n, MPI_DOUBLE, MPI_SUM, 0, context->comm)));
    }
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, &tally->first_error_ray, 1, MPI_UINT64_T, MPI_MIN,
                                    context->comm)));
out:
    return st;
}
