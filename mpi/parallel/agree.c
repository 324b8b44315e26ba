/* SPDX-License-Identifier: MIT
 *
 * Agreement on errors: a rank that fails goes on to the next agreement point, and everyone leaves
 * it the same way.
 */
#include "mpi/parallel/agree.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/nap.h"

enum rmap_status rmap_mpi_check(int code, const char *call, struct rmap_error *err)
{
    if (code == MPI_SUCCESS)
        return RMAP_OK;
    char text[MPI_MAX_ERROR_STRING];
    int len = 0;
    if (MPI_Error_string(code, text, &len) != MPI_SUCCESS)
        (void)snprintf(text, sizeof text, "MPI error %d", code);
    return rmap_error_set(
        err, RMAP_SYSTEM,
        "the ranks cannot reach each other: %.*s failed (%s). Look at what mpirun "
        "says, and whether the hosts share a network that both sides use (mpirun "
        "--mca btl_tcp_if_include NAME); a trace goes on with --resume",
        (int)strcspn(call, "("), call, text);
}

/* MPI itself failing has no agreement left to make: each rank says what it saw. */
enum rmap_status rmap_agree(const struct rmap_context *context, enum rmap_status mine,
                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int first = mine == RMAP_OK ? context->size : context->rank;
    int status = (int)mine;
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, context->comm)));
    if (first == context->size)
        return RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&status, 1, MPI_INT, first, context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(err->text, sizeof err->text, MPI_CHAR, first, context->comm)));
    err->status = (enum rmap_status)status;
    st = err->status;
out:
    return st;
}

enum rmap_status rmap_agree_patiently(const struct rmap_context *context, enum rmap_status mine,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_error mpi_error = {0};
    MPI_Request request;
    int done = 0;
    st = rmap_mpi_check(MPI_Ibarrier(context->comm, &request), "MPI_Ibarrier", &mpi_error);
    while (st == RMAP_OK && !done) {
        st = rmap_mpi_check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test", &mpi_error);
        if (!done)
            rmap_nap();
    }
    if (st == RMAP_OK)
        return rmap_agree(context, mine, err);
    *err = mpi_error;
    return st;
}

enum rmap_status rmap_broadcast_blob(const struct rmap_context *context, uint8_t **blob,
                                     size_t *nbytes, struct rmap_error *err)
{
    const uint64_t piece_nbytes = (uint64_t)1 << 30;
    enum rmap_status st = RMAP_OK;
    uint64_t n = context->rank == 0 ? *nbytes : 0;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&n, 1, MPI_UINT64_T, 0, context->comm)));
    if (context->rank != 0) {
        *blob = rmap_alloc(n ? n : 1, 1);
        *nbytes = n;
        if (!*blob)
            st = rmap_error_set(err, RMAP_SYSTEM, "rank %d: out of memory for %llu bytes",
                                context->rank, (unsigned long long)n);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    for (uint64_t at = 0; at < n; at += piece_nbytes) {
        uint64_t len = n - at < piece_nbytes ? n - at : piece_nbytes;
        RMAP_TRY(RMAP_MPI(MPI_Bcast(*blob + at, (int)len, MPI_BYTE, 0, context->comm)));
    }
out:
    if (st != RMAP_OK && context->rank != 0) {
        rmap_free(*blob);
        *blob = NULL;
    }
    return st;
}
