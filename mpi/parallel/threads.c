/* SPDX-License-Identifier: MIT
 *
 * How many worker threads a rank starts when nobody says.
 */
#define _GNU_SOURCE /* sched_getaffinity */
#include "mpi/parallel/threads.h"

#include <sched.h>
#include <string.h>

/* A launcher may give all ranks of a node all its cores, or each its own: the union of the
 * masks, divided by the ranks, is right for both. */
int rmap_threads_share(MPI_Comm comm)
{
    MPI_Comm node = MPI_COMM_NULL;
    cpu_set_t mine, all;
    int n_rank = 1;
    if (sched_getaffinity(0, sizeof mine, &mine) != 0)
        memset(&mine, 0, sizeof mine);
    all = mine;
    if (MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node) == MPI_SUCCESS) {
        (void)MPI_Comm_size(node, &n_rank);
        (void)MPI_Allreduce(&mine, &all, (int)sizeof all, MPI_BYTE, MPI_BOR, node);
        (void)MPI_Comm_free(&node);
    }
    int share = CPU_COUNT(&all) / n_rank;
    int own = CPU_COUNT(&mine);
    share = share < own ? share : own;
    return share > 1 ? share : 1;
}
