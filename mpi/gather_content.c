/* SPDX-License-Identifier: MIT */
#include "mpi/gather_content.h"

#include "base/alloc.h"
#include "mpi/agree.h"

enum { TAG_CONTENT = 71 };

/* MPI counts are int: long tables travel in pieces. */
static enum rmap_status transfer(const struct rmap_context *context, void *rows, size_t nbytes,
                                 int from, struct rmap_error *err)
{
    const size_t piece = (size_t)1 << 30;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < nbytes; at += piece) {
        uint8_t *bytes = (uint8_t *)rows + at;
        int n = (int)(nbytes - at < piece ? nbytes - at : piece);
        if (context->rank == 0)
            RMAP_TRY(RMAP_MPI(
                MPI_Recv(bytes, n, MPI_BYTE, from, TAG_CONTENT, context->comm, MPI_STATUS_IGNORE)));
        else
            RMAP_TRY(RMAP_MPI(MPI_Send(bytes, n, MPI_BYTE, 0, TAG_CONTENT, context->comm)));
    }
out:
    return st;
}

static enum rmap_status transfer_all(const struct rmap_context *context,
                                     struct rmap_map_content *content, int from,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(
        transfer(context, content->piece, content->n_piece * sizeof *content->piece, from, err));
    RMAP_TRY(transfer(context, content->portion, content->n_portion * sizeof *content->portion,
                      from, err));
    RMAP_TRY(
        transfer(context, content->chunk, content->n_chunk * sizeof *content->chunk, from, err));
out:
    return st;
}

/* Rank 0: one rank's tables, and into the content with them. */
static enum rmap_status receive(const struct rmap_context *context, int from, const uint64_t n[3],
                                struct rmap_map_content *content, struct rmap_error *err)
{
    struct rmap_map_content theirs = {
        .n_piece = (size_t)n[0], .n_portion = (size_t)n[1], .n_chunk = (size_t)n[2]};
    enum rmap_status st = RMAP_OK;
    if (n[0] == 0)
        return RMAP_OK;
    theirs.piece = rmap_alloc(theirs.n_piece, sizeof *theirs.piece);
    theirs.portion = rmap_alloc(theirs.n_portion, sizeof *theirs.portion);
    theirs.chunk = rmap_alloc(theirs.n_chunk, sizeof *theirs.chunk);
    if (!theirs.piece || !theirs.portion || !theirs.chunk) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the pieces of rank %d", from);
        goto out;
    }
    RMAP_TRY(transfer_all(context, &theirs, from, err));
    RMAP_TRY(rmap_map_content_add(content, &theirs, err));
out:
    rmap_map_content_fini(&theirs);
    return st;
}

enum rmap_status rmap_gather_content(const struct rmap_context *context,
                                     const struct rmap_map_content *mine,
                                     struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content own = mine ? *mine : (struct rmap_map_content){0};
    uint64_t counts[3] = {own.n_piece, own.n_portion, own.n_chunk};
    uint64_t(*all)[3] = rmap_alloc((size_t)context->size, sizeof *all);
    if (!all)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Gather(counts, 3, MPI_UINT64_T, all, 3, MPI_UINT64_T, 0, context->comm)));
    if (context->rank == 0 && own.n_piece > 0)
        st = rmap_map_content_add(content, &own, err);
    RMAP_TRY(rmap_agree(context, st, err)); /* a failing rank 0 takes nothing: nobody sends */
    if (context->rank != 0 && own.n_piece > 0)
        RMAP_TRY(transfer_all(context, &own, context->rank, err));
    for (int from = 1; context->rank == 0 && from < context->size; from++)
        RMAP_TRY(receive(context, from, all[from], content, err));
out:
    rmap_free(all);
    return st;
}
