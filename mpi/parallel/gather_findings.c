/* SPDX-License-Identifier: MIT
 *
 * What all ranks found, on rank 0.
 */
#include "mpi/parallel/gather_findings.h"

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

enum { TAG_FINDINGS = 2 };

enum rmap_status rmap_gather_findings(const struct rmap_context *context,
                                      struct rmap_findings *findings, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t mine = findings->n, *all = rmap_alloc((size_t)context->size, sizeof *all);
    size_t total = findings->n;
    if (!all)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Gather(&mine, 1, MPI_UINT64_T, all, 1, MPI_UINT64_T, 0, context->comm)));
    for (int r = 1; context->rank == 0 && r < context->size; r++)
        total += all[r];
    if (context->rank == 0) { /* room for everything first: nothing fails once ranks send */
        st = RMAP_RESERVE(findings->row, findings->cap, total, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t i = 0; context->rank != 0 && i < findings->n; i++)
        RMAP_TRY(RMAP_MPI(MPI_Send(&findings->row[i], sizeof *findings->row, MPI_BYTE, 0,
                                   TAG_FINDINGS, context->comm)));
    for (int r = 1; context->rank == 0 && r < context->size; r++)
        for (uint64_t i = 0; i < all[r]; i++)
            RMAP_TRY(
                RMAP_MPI(MPI_Recv(&findings->row[findings->n++], sizeof *findings->row, MPI_BYTE, r,
                                  TAG_FINDINGS, context->comm, MPI_STATUS_IGNORE)));
    if (context->rank == 0)
        rmap_findings_sort(findings);
out:
    rmap_free(all);
    return st;
}
