/* SPDX-License-Identifier: MIT
 *
 * What rank 0 alone reads of a map in memory, whose portions stand on all ranks.
 */
#include "mpi/scan/head_reads.h"

#include <limits.h>
#include <mpi.h>

#include "base/alloc.h"
#include "io/map/map_held.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/message.h"

enum { TAG_WANTED = 111, TAG_NBYTES, TAG_BYTES };
#define NO_MORE UINT64_MAX

struct rmap_head_reads {
    const struct rmap_context *context;
    const struct rmap_map *map;
    size_t index; /* of the portion that was sent last; SIZE_MAX: none */
    struct rmap_message *message;
    struct rmap_portion portion; /* in it */
};

/* On rank 0. */
static enum rmap_status receive(struct rmap_head_reads *self, size_t portion,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int owner = rmap_map_portion(self->map, portion)->shard;
    const MPI_Comm comm = self->context->comm;
    const uint64_t wanted = portion;
    uint64_t nbytes = 0;
    rmap_message_destroy(self->message);
    self->message = NULL;
    self->index = SIZE_MAX;
    RMAP_TRY(RMAP_MPI(MPI_Send(&wanted, 1, MPI_UINT64_T, owner, TAG_WANTED, comm)));
    RMAP_TRY(
        RMAP_MPI(MPI_Recv(&nbytes, 1, MPI_UINT64_T, owner, TAG_NBYTES, comm, MPI_STATUS_IGNORE)));
    if (nbytes == 0)
        return rmap_error_set(err, RMAP_SYSTEM,
                              "rank %d has no memory for rays that it is to send, or too many of "
                              "them",
                              owner);
    RMAP_TRY(rmap_message_create((size_t)nbytes, &self->message, err));
    RMAP_TRY(RMAP_MPI(MPI_Recv(self->message->bytes, (int)nbytes, MPI_BYTE, owner, TAG_BYTES, comm,
                               MPI_STATUS_IGNORE)));
    RMAP_TRY(rmap_message_view(self->message, &self->portion, err));
    self->index = portion;
out:
    return st;
}

/* As rmap_held_elsewhere.fetch. */
static enum rmap_status fetch(void *context, size_t portion,
                              const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    struct rmap_head_reads *self = context;
    *portion_ret = &self->portion;
    return self->index == portion ? RMAP_OK : receive(self, portion, err);
}

/* On other ranks: what rank 0 wants, until it wants no more. */
static enum rmap_status send_wanted(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (;;) {
        uint64_t wanted = NO_MORE, nbytes = 0;
        const struct rmap_portion *portion = NULL;
        struct rmap_message *message = NULL;
        RMAP_TRY(RMAP_MPI(
            MPI_Recv(&wanted, 1, MPI_UINT64_T, 0, TAG_WANTED, context->comm, MPI_STATUS_IGNORE)));
        if (wanted == NO_MORE)
            goto out;
        if (rmap_map_held_portion(map, (size_t)wanted, &portion, NULL) == RMAP_OK &&
            rmap_message_pack(portion, RMAP_COLUMNS_ALL, &message, NULL) == RMAP_OK &&
            message->nbytes <= INT_MAX)
            nbytes = message->nbytes;
        st = RMAP_MPI(MPI_Send(&nbytes, 1, MPI_UINT64_T, 0, TAG_NBYTES, context->comm));
        if (st == RMAP_OK && nbytes > 0)
            st = RMAP_MPI(
                MPI_Send(message->bytes, (int)nbytes, MPI_BYTE, 0, TAG_BYTES, context->comm));
        rmap_message_destroy(message);
        RMAP_TRY(st);
    }
out:
    return st;
}

enum rmap_status rmap_head_reads_begin(const struct rmap_context *context,
                                       const struct rmap_map *map,
                                       struct rmap_head_reads **reads_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_head_reads *self = NULL;
    *reads_ret = NULL;
    if (!rmap_map_is_held(map) || context->size == 1)
        return RMAP_OK;
    if (context->rank == 0 && !(self = rmap_alloc(1, sizeof *self)))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays of other ranks");
    st = rmap_agree(context, st, err);
    if (st == RMAP_OK && context->rank > 0)
        return send_wanted(context, map, err);
    if (st != RMAP_OK) {
        rmap_free(self);
        return st;
    }
    *self = (struct rmap_head_reads){.context = context, .map = map, .index = SIZE_MAX};
    rmap_map_set_elsewhere(map, (struct rmap_held_elsewhere){fetch, self});
    *reads_ret = self;
    return RMAP_OK;
}

void rmap_head_reads_end(struct rmap_head_reads *reads)
{
    const uint64_t no_more = NO_MORE;
    if (!reads)
        return;
    rmap_map_set_elsewhere(reads->map, (struct rmap_held_elsewhere){NULL, NULL});
    for (int r = 1; r < reads->context->size; r++)
        (void)MPI_Send(&no_more, 1, MPI_UINT64_T, r, TAG_WANTED, reads->context->comm);
    rmap_message_destroy(reads->message);
    rmap_free(reads);
}
