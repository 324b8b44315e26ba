/* SPDX-License-Identifier: MIT
 *
 * Few writers for many ranks: on each node the first ranks write shards, the others send them
 * their traced blocks.
 */
#include "mpi/trace/forward.h"

#include <pthread.h>
#include <stdatomic.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"

enum { TAG_SIZE = 1, TAG_BYTES };

/* Blocks that travel at a time per sender, and those that wait before workers do. */
enum { TRAVELLING_MAX = 4, WAITING_MAX = 8 };

/* A block on its way: its size first (0: no more will come), then its bytes. */
struct transfer {
    struct transfer *next;
    struct rmap_message *message; /* NULL: the size 0 */
    uint64_t size;
    MPI_Request *request;
    int n_request;
};

struct rmap_forward {
    MPI_Comm comm;
    int writer;   /* rank that takes this one's blocks */
    int n_sender; /* that have not ended yet, if this rank writes */
    bool writes, ended;
    /* A block whose size came and whose bytes are not received yet; size 0: none. */
    uint64_t announced;
    int announced_by;
    struct transfer *travelling; /* the MPI thread's own, oldest first */
    int n_travelling;

    pthread_mutex_t lock;
    struct transfer *waiting, **waiting_end; /* under the lock */
    _Atomic int n_waiting;
};

/* Writers are the first ranks of a node; the others take them in turn. */
static enum rmap_status find_writer(struct rmap_forward *self, const struct rmap_context *context,
                                    uint64_t per_node, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Comm node = MPI_COMM_NULL;
    int rank = 0, size = 1;
    int *world = NULL;
    RMAP_TRY(RMAP_MPI(MPI_Comm_split_type(self->comm, MPI_COMM_TYPE_SHARED, context->rank,
                                          MPI_INFO_NULL, &node)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_rank(node, &rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(node, &size)));
    world = rmap_alloc((size_t)size, sizeof *world);
    if (!world)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", size);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Allgather(&context->rank, 1, MPI_INT, world, 1, MPI_INT, node)));
    int n_writer = per_node < (uint64_t)size ? (int)per_node : size;
    self->writes = rank < n_writer;
    self->writer = world[rank % n_writer];
    self->n_sender = self->writes ? (size - rank - 1) / n_writer : 0;
out:
    if (node != MPI_COMM_NULL)
        (void)MPI_Comm_free(&node);
    rmap_free(world);
    return st;
}

enum rmap_status rmap_forward_create(const struct rmap_context *context, uint64_t per_node,
                                     struct rmap_forward **forward_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *forward_ret = NULL;
    if (per_node == 0)
        return RMAP_OK;
    struct rmap_forward *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_agree(context, rmap_error_set(err, RMAP_SYSTEM, "out of memory"), err);
    self->comm = MPI_COMM_NULL;
    self->waiting_end = &self->waiting;
    (void)pthread_mutex_init(&self->lock, NULL);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Comm_dup(context->comm, &self->comm)));
    RMAP_TRY(find_writer(self, context, per_node, err));
    *forward_ret = self;
    self = NULL;
out:
    rmap_forward_destroy(self);
    return st;
}

static void transfer_destroy(struct transfer *transfer)
{
    rmap_message_destroy(transfer->message);
    rmap_free(transfer->request);
    rmap_free(transfer);
}

static void destroy_list(struct transfer *transfer)
{
    for (struct transfer *next; transfer; transfer = next) {
        next = transfer->next;
        transfer_destroy(transfer);
    }
}

void rmap_forward_destroy(struct rmap_forward *self)
{
    if (!self)
        return;
    destroy_list(self->travelling);
    destroy_list(self->waiting);
    (void)pthread_mutex_destroy(&self->lock);
    if (self->comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&self->comm);
    rmap_free(self);
}

bool rmap_forward_writes(const struct rmap_forward *self)
{
    return !self || self->writes;
}

bool rmap_forward_full(const struct rmap_forward *self)
{
    return atomic_load(&self->n_waiting) >= WAITING_MAX;
}

/* A transfer with room for its requests: the size, and the bytes in pieces that int counts hold. */
static const size_t piece_nbytes = (size_t)1 << 30;

static struct transfer *transfer_create(struct rmap_message *message)
{
    struct transfer *transfer = rmap_alloc(1, sizeof *transfer);
    if (!transfer)
        return NULL;
    transfer->size = message ? message->nbytes : 0;
    transfer->request =
        rmap_alloc((size_t)(transfer->size / piece_nbytes) + 2, sizeof *transfer->request);
    if (!transfer->request) {
        rmap_free(transfer);
        return NULL;
    }
    transfer->message = message;
    return transfer;
}

enum rmap_status rmap_forward_put(struct rmap_forward *self, struct rmap_message *message,
                                  struct rmap_error *err)
{
    struct transfer *transfer = transfer_create(message);
    if (!transfer) {
        rmap_message_destroy(message);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block to be sent");
    }
    (void)pthread_mutex_lock(&self->lock);
    *self->waiting_end = transfer;
    self->waiting_end = &transfer->next;
    atomic_fetch_add(&self->n_waiting, 1);
    (void)pthread_mutex_unlock(&self->lock);
    return RMAP_OK;
}

static struct transfer *take_waiting(struct rmap_forward *self)
{
    (void)pthread_mutex_lock(&self->lock);
    struct transfer *transfer = self->waiting;
    if (transfer) {
        self->waiting = transfer->next;
        transfer->next = NULL;
        if (!self->waiting)
            self->waiting_end = &self->waiting;
        atomic_fetch_sub(&self->n_waiting, 1);
    }
    (void)pthread_mutex_unlock(&self->lock);
    return transfer;
}

static void add_travelling(struct rmap_forward *self, struct transfer *transfer)
{
    struct transfer **end = &self->travelling;
    while (*end)
        end = &(*end)->next;
    *end = transfer;
    self->n_travelling++;
}

/* Posts the bytes: `send` or receive, from or to the rank `peer`. */
static enum rmap_status post_bytes(struct rmap_forward *self, struct transfer *transfer, int peer,
                                   bool send, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < transfer->size; at += piece_nbytes) {
        size_t left = (size_t)transfer->size - at;
        int n = (int)(left < piece_nbytes ? left : piece_nbytes);
        uint8_t *bytes = transfer->message->bytes + at;
        MPI_Request *request = &transfer->request[transfer->n_request];
        if (send)
            RMAP_TRY(
                RMAP_MPI(MPI_Issend(bytes, n, MPI_BYTE, peer, TAG_BYTES, self->comm, request)));
        else
            RMAP_TRY(RMAP_MPI(MPI_Irecv(bytes, n, MPI_BYTE, peer, TAG_BYTES, self->comm, request)));
        transfer->n_request++;
    }
out:
    return st;
}

static enum rmap_status begin_send(struct rmap_forward *self, struct transfer *transfer,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    add_travelling(self, transfer);
    RMAP_TRY(RMAP_MPI(MPI_Issend(&transfer->size, 1, MPI_UINT64_T, self->writer, TAG_SIZE,
                                 self->comm, &transfer->request[transfer->n_request])));
    transfer->n_request++;
    RMAP_TRY(post_bytes(self, transfer, self->writer, true, err));
out:
    return st;
}

/* Takes the first finished transfer out of the list, or none. */
static enum rmap_status take_arrived(struct rmap_forward *self, struct transfer **transfer_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *transfer_ret = NULL;
    for (struct transfer **at = &self->travelling; *at; at = &(*at)->next) {
        struct transfer *transfer = *at;
        int done = 0;
        RMAP_TRY(RMAP_MPI(
            MPI_Testall(transfer->n_request, transfer->request, &done, MPI_STATUSES_IGNORE)));
        if (!done)
            continue;
        *at = transfer->next;
        self->n_travelling--;
        *transfer_ret = transfer;
        break;
    }
out:
    return st;
}

enum rmap_status rmap_forward_send(struct rmap_forward *self, bool last, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct transfer *transfer = NULL;
    do {
        RMAP_TRY(take_arrived(self, &transfer, err));
        if (transfer)
            transfer_destroy(transfer);
    } while (transfer);
    while (self->n_travelling < TRAVELLING_MAX && (transfer = take_waiting(self)))
        RMAP_TRY(begin_send(self, transfer, err));
    if (last && !self->ended && atomic_load(&self->n_waiting) == 0) {
        transfer = transfer_create(NULL);
        if (!transfer) {
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
            goto out;
        }
        self->ended = true;
        RMAP_TRY(begin_send(self, transfer, err));
    }
out:
    return st;
}

/* Hears of a sender's next block, unless one is announced already. */
static enum rmap_status listen(struct rmap_forward *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Status status;
    int waiting = 0;
    uint64_t size = 0;
    if (self->announced > 0)
        return RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Iprobe(MPI_ANY_SOURCE, TAG_SIZE, self->comm, &waiting, &status)));
    if (!waiting)
        return RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Recv(&size, 1, MPI_UINT64_T, status.MPI_SOURCE, TAG_SIZE, self->comm,
                               MPI_STATUS_IGNORE)));
    self->announced = size;
    self->announced_by = status.MPI_SOURCE;
    self->n_sender -= size == 0;
out:
    return st;
}

/* Begins to receive the next block, if one is announced; without memory it stays announced. */
static enum rmap_status begin_receive(struct rmap_forward *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_message *message = NULL;
    RMAP_TRY(listen(self, err));
    if (self->announced == 0)
        return RMAP_OK;
    RMAP_TRY(rmap_message_create((size_t)self->announced, &message, err));
    struct transfer *transfer = transfer_create(message);
    if (!transfer) {
        rmap_message_destroy(message);
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block to come");
        goto out;
    }
    self->announced = 0;
    add_travelling(self, transfer);
    RMAP_TRY(post_bytes(self, transfer, self->announced_by, false, err));
out:
    return st;
}

/* The bytes of the announced block, to nowhere: MPI cuts them off and says so. */
static enum rmap_status swallow(struct rmap_forward *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t nothing;
    for (uint64_t at = 0; at < self->announced; at += piece_nbytes) {
        int class = MPI_SUCCESS;
        int code = MPI_Recv(&nothing, 0, MPI_BYTE, self->announced_by, TAG_BYTES, self->comm,
                            MPI_STATUS_IGNORE);
        RMAP_TRY(RMAP_MPI(MPI_Error_class(code, &class)));
        if (class != MPI_ERR_TRUNCATE)
            RMAP_TRY(RMAP_MPI(code));
    }
    self->announced = 0;
out:
    return st;
}

enum rmap_status rmap_forward_discard(struct rmap_forward *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct transfer *transfer = NULL;
    RMAP_TRY(listen(self, err));
    RMAP_TRY(swallow(self, err));
    RMAP_TRY(take_arrived(self, &transfer, err));
    if (transfer)
        transfer_destroy(transfer);
out:
    return st;
}

enum rmap_status rmap_forward_receive(struct rmap_forward *self, bool hold,
                                      struct rmap_message **message_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct transfer *transfer = NULL;
    *message_ret = NULL;
    if (!hold && self->n_sender > 0 && self->n_travelling < TRAVELLING_MAX)
        RMAP_TRY(begin_receive(self, err));
    RMAP_TRY(take_arrived(self, &transfer, err));
    if (transfer) {
        *message_ret = transfer->message;
        transfer->message = NULL;
        transfer_destroy(transfer);
    }
out:
    return st;
}

bool rmap_forward_done(const struct rmap_forward *self)
{
    if (!self)
        return true;
    return self->n_travelling == 0 && (self->writes ? self->n_sender == 0 : self->ended);
}
