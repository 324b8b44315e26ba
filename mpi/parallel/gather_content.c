/* SPDX-License-Identifier: MIT
 *
 * What every rank's writer published, on rank 0: the index is made of it, and no rank looks at
 * another's disk.
 */
#include "mpi/parallel/gather_content.h"

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

enum { TAG_CONTENT = 71 };

/* MPI counts are int: long lists travel in pieces. */
static enum rmap_status transfer(const struct rmap_context *context, uint8_t *blob, size_t nbytes,
                                 int from, struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 30;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < nbytes; at += piece) {
        int n = (int)(nbytes - at < piece ? nbytes - at : piece);
        if (context->rank == 0)
            RMAP_TRY(RMAP_MPI(MPI_Recv(blob + at, n, MPI_BYTE, from, TAG_CONTENT, context->comm,
                                       MPI_STATUS_IGNORE)));
        else
            RMAP_TRY(RMAP_MPI(MPI_Send(blob + at, n, MPI_BYTE, 0, TAG_CONTENT, context->comm)));
    }
out:
    return st;
}

/* Rank 0: all lists, one after the other through `room`, and into the content with them. What fails
 * to be taken up is received all the same, for its sender waits. */
static enum rmap_status receive(const struct rmap_context *context, const uint64_t *nbytes,
                                uint8_t *room, struct rmap_map_content *content,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK, unpacked = RMAP_OK;
    for (int from = 1; from < context->size; from++) {
        RMAP_TRY(transfer(context, room, (size_t)nbytes[from], from, err));
        if (unpacked == RMAP_OK && nbytes[from] > 0)
            unpacked = rmap_map_content_unpack(room, (size_t)nbytes[from], content, err);
    }
    st = unpacked;
out:
    return st;
}

enum rmap_status rmap_gather_content(const struct rmap_context *context,
                                     const struct rmap_map_content *mine,
                                     struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    uint64_t *all = rmap_alloc((size_t)context->size, sizeof *all);
    if (!all) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    } else if (context->rank == 0 && mine) {
        st = rmap_map_content_add(content, mine, err);
    } else if (mine && mine->n_piece > 0) {
        nbytes = rmap_map_content_packed_nbytes(mine);
        blob = rmap_alloc_unset(nbytes, 1);
        if (blob)
            rmap_map_content_pack(mine, &(struct rmap_packing){.to = blob});
        else
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a list of %zu pieces",
                                mine->n_piece);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    const uint64_t n = nbytes;
    RMAP_TRY(RMAP_MPI(MPI_Gather(&n, 1, MPI_UINT64_T, all, 1, MPI_UINT64_T, 0, context->comm)));
    if (context->rank == 0) {
        for (int from = 1; from < context->size; from++)
            nbytes = all[from] > nbytes ? (size_t)all[from] : nbytes;
        blob = rmap_alloc(nbytes, 1);
        if (!blob)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the pieces of other ranks");
    }
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank == 0)
        st = receive(context, all, blob, content, err);
    else
        st = transfer(context, blob, nbytes, context->rank, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_free(blob);
    rmap_free(all);
    return st;
}
