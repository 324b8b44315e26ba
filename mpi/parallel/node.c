/* SPDX-License-Identifier: MIT
 *
 * Ranks of one node, and memory that they share.
 */
#include "mpi/parallel/node.h"

#include <unistd.h>

#include "io/file/shared_memory.h"
#include "mpi/parallel/agree.h"

/* Of the ranks of a node: its first one makes memory, and all open it or none. */
static enum rmap_status open_memory(struct rmap_node *self, MPI_Comm ranks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_shared_place place = {0};
    int rank = 0, size = 1, all = 0;
    RMAP_TRY(RMAP_MPI(MPI_Comm_rank(ranks, &rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(ranks, &size)));
    if (size == 1)
        goto out;
    if (rank == 0)
        self->memory = rmap_shared_memory_create(&place);
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&place, (int)sizeof place, MPI_BYTE, 0, ranks)));
    if (rank != 0)
        self->memory = rmap_shared_memory_open(&place);
    all = self->memory >= 0;
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, ranks)));
    self->is_first = rank == 0 || !all;
    if (!all && self->memory >= 0) {
        (void)close(self->memory);
        self->memory = -1;
    }
out:
    return st;
}

enum rmap_status rmap_node_init(struct rmap_node *node, const struct rmap_context *context,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Comm ranks = MPI_COMM_NULL;
    *node = (struct rmap_node){.is_first = true, .memory = -1, .firsts = *context};
    node->firsts.comm = MPI_COMM_NULL;
    RMAP_TRY(RMAP_MPI(MPI_Comm_split_type(context->comm, MPI_COMM_TYPE_SHARED, context->rank,
                                          MPI_INFO_NULL, &ranks)));
    RMAP_TRY(open_memory(node, ranks, err));
    RMAP_TRY(RMAP_MPI(MPI_Comm_split(context->comm, node->is_first ? 0 : MPI_UNDEFINED,
                                     context->rank, &node->firsts.comm)));
    if (node->is_first) {
        RMAP_TRY(RMAP_MPI(MPI_Comm_rank(node->firsts.comm, &node->firsts.rank)));
        RMAP_TRY(RMAP_MPI(MPI_Comm_size(node->firsts.comm, &node->firsts.size)));
    }
out:
    if (ranks != MPI_COMM_NULL)
        (void)MPI_Comm_free(&ranks);
    return st;
}

void rmap_node_fini(struct rmap_node *node)
{
    if (node->memory >= 0)
        (void)close(node->memory);
    if (node->firsts.comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&node->firsts.comm);
}
