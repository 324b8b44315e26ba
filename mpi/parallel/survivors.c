/* SPDX-License-Identifier: MIT
 *
 * When a rank does not answer, the others leave it behind and go on among themselves.
 */
#include "mpi/parallel/survivors.h"

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/watchdog.h"

enum { TAG_SURVIVORS = 61, TAG_GROUP };

/* Collective over the ranks listed, ascending, rank 0 first. */
static enum rmap_status join(const struct rmap_context *context, const int *rank, int n,
                             struct rmap_survivors *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Group all = MPI_GROUP_NULL, some = MPI_GROUP_NULL;
    self->context = *context;
    RMAP_TRY(RMAP_MPI(MPI_Comm_group(context->comm, &all)));
    RMAP_TRY(RMAP_MPI(MPI_Group_incl(all, n, rank, &some)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_create_group(context->comm, some, TAG_GROUP, &self->context.comm)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_rank(self->context.comm, &self->context.rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(self->context.comm, &self->context.size)));
out:
    if (some != MPI_GROUP_NULL)
        (void)MPI_Group_free(&some);
    if (all != MPI_GROUP_NULL)
        (void)MPI_Group_free(&all);
    return st;
}

enum rmap_status rmap_survivors_gather(const struct rmap_context *context, int missing,
                                       const char *host, double seconds,
                                       struct rmap_survivors *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int n = 0;
    int *rank = rmap_alloc((size_t)context->size, sizeof *rank);
    if (!rank)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    rmap_watchdog_end_in(context->watchdog, seconds);
    self->missing = missing;
    self->host = host;
    for (int r = 0; r < context->size; r++)
        if (!rmap_watchdog_is_silent(context->watchdog, r))
            rank[n++] = r;
    for (int i = 1; i < n; i++)
        RMAP_TRY(RMAP_MPI(MPI_Send(rank, n, MPI_INT, rank[i], TAG_SURVIVORS, context->comm)));
    RMAP_TRY(join(context, rank, n, self, err));
out:
    rmap_free(rank);
    return st;
}

enum rmap_status rmap_survivors_heed(const struct rmap_context *context,
                                     struct rmap_survivors *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int waiting = 0, n = 0;
    int *rank = NULL;
    MPI_Status status;
    RMAP_TRY(RMAP_MPI(MPI_Iprobe(0, TAG_SURVIVORS, context->comm, &waiting, &status)));
    if (!waiting)
        goto out;
    RMAP_TRY(RMAP_MPI(MPI_Get_count(&status, MPI_INT, &n)));
    rank = rmap_alloc((size_t)n, sizeof *rank);
    if (!rank)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", n));
    RMAP_TRY(
        RMAP_MPI(MPI_Recv(rank, n, MPI_INT, 0, TAG_SURVIVORS, context->comm, MPI_STATUS_IGNORE)));
    for (self->missing = 1; self->missing < n && rank[self->missing] == self->missing;)
        self->missing++;
    RMAP_TRY(join(context, rank, n, self, err));
out:
    rmap_free(rank);
    return st;
}
