/* SPDX-License-Identifier: MIT */
#include "mpi/blocks.h"

#include "base/alloc.h"
#include "mpi/agree.h"

/* Far above any number of blocks, far below overflow by the additions that still come. */
#define STOPPED ((uint64_t)1 << 62)

struct rmap_blocks {
    MPI_Win window;
    MPI_Comm comm;
    uint64_t *counter; /* in rank 0's window */
    uint64_t n_block;
    bool locked;
};

enum rmap_status rmap_blocks_create(const struct rmap_context *context, uint64_t n_block,
                                    struct rmap_blocks **blocks_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_blocks *blocks = rmap_alloc(1, sizeof *blocks);
    if (!blocks)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    RMAP_TRY(rmap_agree(context, st, err));
    blocks->window = MPI_WIN_NULL;
    blocks->comm = context->comm;
    blocks->n_block = n_block;
    MPI_Aint nbytes = context->rank == 0 ? (MPI_Aint)sizeof(uint64_t) : 0;
    RMAP_TRY(RMAP_MPI(MPI_Win_allocate(nbytes, sizeof(uint64_t), MPI_INFO_NULL, context->comm,
                                       &blocks->counter, &blocks->window)));
    RMAP_TRY(RMAP_MPI(MPI_Win_set_errhandler(blocks->window, MPI_ERRORS_RETURN)));
    if (context->rank == 0)
        *blocks->counter = 0;
    RMAP_TRY(RMAP_MPI(MPI_Barrier(context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Win_lock_all(MPI_MODE_NOCHECK, blocks->window)));
    blocks->locked = true;
    *blocks_ret = blocks;
    blocks = NULL;
out:
    rmap_blocks_destroy(blocks);
    return st;
}

void rmap_blocks_destroy(struct rmap_blocks *blocks)
{
    if (!blocks)
        return;
    if (blocks->locked)
        (void)MPI_Win_unlock_all(blocks->window);
    if (blocks->window != MPI_WIN_NULL)
        (void)MPI_Win_free(&blocks->window);
    rmap_free(blocks);
}

static enum rmap_status fetch(struct rmap_blocks *blocks, uint64_t operand, MPI_Op op,
                              uint64_t *before, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Fetch_and_op(&operand, before, MPI_UINT64_T, 0, 0, op, blocks->window)));
    RMAP_TRY(RMAP_MPI(MPI_Win_flush(0, blocks->window)));
out:
    return st;
}

enum rmap_status rmap_blocks_next(struct rmap_blocks *blocks, uint64_t *block_ret,
                                  struct rmap_error *err)
{
    uint64_t before = 0;
    enum rmap_status st = fetch(blocks, 1, MPI_SUM, &before, err);
    if (st == RMAP_OK)
        *block_ret = before < blocks->n_block ? before : blocks->n_block;
    return st;
}

enum rmap_status rmap_blocks_stop(struct rmap_blocks *blocks, struct rmap_error *err)
{
    uint64_t before = 0;
    return fetch(blocks, STOPPED, MPI_REPLACE, &before, err);
}

enum rmap_status rmap_blocks_stopped(struct rmap_blocks *blocks, bool *stopped_ret,
                                     struct rmap_error *err)
{
    uint64_t now = 0;
    enum rmap_status st = fetch(blocks, 0, MPI_NO_OP, &now, err);
    *stopped_ret = st == RMAP_OK && now >= STOPPED;
    return st;
}

enum rmap_status rmap_blocks_poll(struct rmap_blocks *blocks, uint64_t *handed_out_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int waiting = 0;
    uint64_t before = 0;
    RMAP_TRY(RMAP_MPI(
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, blocks->comm, &waiting, MPI_STATUS_IGNORE)));
    RMAP_TRY(fetch(blocks, 0, MPI_NO_OP, &before, err));
    *handed_out_ret = before < blocks->n_block ? before : blocks->n_block;
out:
    return st;
}
