/* SPDX-License-Identifier: MIT
 *
 * Every rank sends its finished parts in order, each when rank 0 asks for it by receiving: what
 * waits, waits where it was made. Rank 0 takes the part that begins with the smallest id next, and
 * hands out the rays below the first id of all parts that are still to come; where portions have
 * gaps, as in a map of a query, they may lie within each other.
 *
 * However it ends, rank 0 tells every rank to stop, and takes what they still send until each says
 * that it has ended.
 */
#include "mpi/scan/ray_stream.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/ray_order.h"
#include "mpi/scan/ray_parts.h"
#include "mpi/scan/scan.h"

enum { TAG_HEAD = 81, TAG_LIST, TAG_BYTES, TAG_STOP };
enum { PIECE_NBYTES = 1 << 24 };

/* What a rank says next. */
enum say { SAY_PART, SAY_FAILED, SAY_END };

struct stream {
    const struct rmap_context *context;
    const struct rmap_map *map;
    struct rmap_deal deal;
    struct rmap_ray_parts *parts;
    uint64_t limit;

    /* rank 0 */
    size_t *next; /* [ranks] parts taken */
    bool *ended;  /* [ranks] */
    struct rmap_ray_order order;
    uint8_t *scratch;     /* [PIECE_NBYTES] */
    MPI_Request *request; /* [ranks] */
};

/* Sheaves of a part: portion and bytes of each. */
struct listed {
    uint64_t sheaf[RMAP_DEAL_STEP_MAX][2];
};

/* A message travels in pieces, each of which rank 0 can take without asking for memory.
 * bytes NULL: they are dropped. */
static enum rmap_status transfer(const struct stream *self, uint8_t *bytes, size_t nbytes, int from,
                                 struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < nbytes; at += PIECE_NBYTES) {
        int n = (int)(nbytes - at < PIECE_NBYTES ? nbytes - at : PIECE_NBYTES);
        if (context->rank == 0)
            RMAP_TRY(RMAP_MPI(MPI_Recv(bytes ? bytes + at : self->scratch, n, MPI_BYTE, from,
                                       TAG_BYTES, context->comm, MPI_STATUS_IGNORE)));
        else
            RMAP_TRY(RMAP_MPI(MPI_Send(bytes + at, n, MPI_BYTE, 0, TAG_BYTES, context->comm)));
    }
out:
    return st;
}

/* ---- the other ranks ---- */

/* The head waits, asleep, until rank 0 wants it; what follows then goes at once. */
static enum rmap_status send(const struct stream *self, enum say say,
                             const struct rmap_sheaves *sheaves, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    const uint64_t head[2] = {(uint64_t)say, sheaves ? sheaves->n : 0};
    struct listed list;
    MPI_Request request;
    int done = 0;
    RMAP_TRY(RMAP_MPI(MPI_Issend(head, 2, MPI_UINT64_T, 0, TAG_HEAD, context->comm, &request)));
    while (!done) {
        RMAP_TRY(RMAP_MPI(MPI_Test(&request, &done, MPI_STATUS_IGNORE)));
        if (!done)
            rmap_ray_parts_nap();
    }
    for (size_t i = 0; i < head[1]; i++) {
        list.sheaf[i][0] = sheaves->sheaf[i].portion;
        list.sheaf[i][1] = sheaves->sheaf[i].message->nbytes;
    }
    if (head[1] > 0)
        RMAP_TRY(RMAP_MPI(
            MPI_Send(&list, (int)(2 * head[1]), MPI_UINT64_T, 0, TAG_LIST, context->comm)));
    for (size_t i = 0; i < head[1]; i++) {
        struct rmap_message *message = sheaves->sheaf[i].message;
        RMAP_TRY(transfer(self, message->bytes, message->nbytes, 0, err));
    }
out:
    return st;
}

static enum rmap_status told_to_stop(const struct rmap_context *context, bool *stop,
                                     struct rmap_error *err)
{
    int waiting = 0;
    enum rmap_status st =
        RMAP_MPI(MPI_Iprobe(0, TAG_STOP, context->comm, &waiting, MPI_STATUS_IGNORE));
    *stop = waiting != 0;
    return st;
}

static enum rmap_status send_parts(struct stream *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = self->context;
    bool stop = false;
    for (size_t k = 0; k < rmap_deal_n_part(&self->deal, context->rank) && !stop;) {
        struct rmap_sheaves sheaves = {0};
        bool done = false;
        RMAP_TRY(told_to_stop(context, &stop, err));
        if (stop)
            break;
        RMAP_TRY(rmap_ray_parts_take(self->parts, &done, &sheaves, err));
        if (done)
            st = send(self, SAY_PART, &sheaves, err);
        else
            rmap_ray_parts_nap();
        k += done;
        rmap_sheaves_fini(&sheaves);
        RMAP_TRY(st);
    }
out:
    return st;
}

/* Says how it ended, whatever happened, and waits until rank 0 has done with all. */
static enum rmap_status serve(struct stream *self, enum rmap_status begun, struct rmap_error *err)
{
    const struct rmap_context *context = self->context;
    enum rmap_status st = begun == RMAP_OK ? send_parts(self, err) : begun;
    enum rmap_status said = RMAP_OK, heard = RMAP_OK;
    struct rmap_error talk = {0};
    bool stop = false;
    if (st != RMAP_OK)
        said = send(self, SAY_FAILED, NULL, &talk);
    if (said == RMAP_OK)
        said = send(self, SAY_END, NULL, &talk);
    while (heard == RMAP_OK && !stop) {
        heard = told_to_stop(context, &stop, &talk);
        rmap_ray_parts_nap();
    }
    if (heard == RMAP_OK) {
        int word;
        heard = rmap_mpi_check(
            MPI_Recv(&word, 1, MPI_INT, 0, TAG_STOP, context->comm, MPI_STATUS_IGNORE), "MPI_Recv",
            &talk);
    }
    if (st == RMAP_OK && (said != RMAP_OK || heard != RMAP_OK))
        st = rmap_error_set(err, RMAP_SYSTEM, "%s", talk.text);
    return st;
}

/* ---- rank 0 ---- */

/* What another rank sends: held, or dropped when nobody wants it any more. */
static enum rmap_status receive(struct stream *self, int from, bool keep, enum say *say,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK, kept = RMAP_OK;
    MPI_Comm comm = self->context->comm;
    uint64_t head[2] = {0};
    struct listed list;
    int waiting = 0;
    while (!waiting) {
        RMAP_TRY(RMAP_MPI(MPI_Iprobe(from, TAG_HEAD, comm, &waiting, MPI_STATUS_IGNORE)));
        if (!waiting)
            rmap_ray_parts_nap();
    }
    RMAP_TRY(RMAP_MPI(MPI_Recv(head, 2, MPI_UINT64_T, from, TAG_HEAD, comm, MPI_STATUS_IGNORE)));
    *say = (enum say)head[0];
    if (head[1] > 0)
        RMAP_TRY(RMAP_MPI(MPI_Recv(&list, (int)(2 * head[1]), MPI_UINT64_T, from, TAG_LIST, comm,
                                   MPI_STATUS_IGNORE)));
    for (size_t i = 0; i < head[1]; i++) {
        struct rmap_message *message = NULL;
        if (keep && kept == RMAP_OK)
            kept = rmap_message_create((size_t)list.sheaf[i][1], &message, err);
        st = transfer(self, message ? message->bytes : NULL, (size_t)list.sheaf[i][1], from, err);
        if (st == RMAP_OK && message)
            kept = rmap_ray_order_add(&self->order, (size_t)list.sheaf[i][0], message, err);
        else
            rmap_message_destroy(message);
        RMAP_TRY(st);
    }
    st = kept;
out:
    return st;
}

static enum rmap_status take_own(struct stream *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_sheaves sheaves = {0};
    bool done = false;
    while (!done) {
        RMAP_TRY(rmap_ray_parts_take(self->parts, &done, &sheaves, err));
        if (!done)
            rmap_ray_parts_nap();
    }
    for (size_t i = 0; i < sheaves.n && st == RMAP_OK; i++) {
        struct rmap_message *message = sheaves.sheaf[i].message;
        sheaves.sheaf[i].message = NULL;
        st = rmap_ray_order_add(&self->order, sheaves.sheaf[i].portion, message, err);
    }
out:
    rmap_sheaves_fini(&sheaves);
    return st;
}

/* First portion of the rank's next part; SIZE_MAX: it has no more. */
static size_t next_portion(const struct stream *self, int rank)
{
    size_t n;
    return self->next[rank] < rmap_deal_n_part(&self->deal, rank)
               ? rmap_deal_part(&self->deal, rank, self->next[rank], &n)[0]
               : SIZE_MAX;
}

/* The rank whose next part begins first, and the first id of all parts still to come. */
static int choose(const struct stream *self, uint64_t *first_ray)
{
    size_t least = SIZE_MAX;
    int chosen = -1;
    for (int r = 0; r < self->context->size; r++) {
        size_t portion = next_portion(self, r);
        if (portion < least) {
            least = portion;
            chosen = r;
        }
    }
    *first_ray = chosen < 0 ? UINT64_MAX : rmap_map_portion(self->map, least)->first_ray;
    return chosen;
}

static enum rmap_status gather(struct stream *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t first_ray;
    int from;
    while (self->order.n < self->limit && (from = choose(self, &first_ray)) >= 0) {
        enum say say = SAY_PART;
        if (from == 0)
            RMAP_TRY(take_own(self, err));
        else
            RMAP_TRY(receive(self, from, true, &say, err));
        if (say != SAY_PART) {
            self->ended[from] = say == SAY_END;
            if (say == SAY_END)
                st = rmap_error_set(err, RMAP_INTERNAL, "rank %d ended before its last part", from);
            goto out; /* why it failed, that rank says when all agree */
        }
        self->next[from]++;
        (void)choose(self, &first_ray);
        RMAP_TRY(rmap_ray_order_hand_out(&self->order, first_ray, err));
    }
out:
    return st;
}

/* Tells all ranks to stop, and takes what they send until they have. */
static enum rmap_status conclude(struct stream *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int size = self->context->size, word = 0;
    for (int r = 1; r < size; r++)
        RMAP_TRY(RMAP_MPI(
            MPI_Isend(&word, 1, MPI_INT, r, TAG_STOP, self->context->comm, &self->request[r])));
    for (int r = 1; r < size; r++)
        while (!self->ended[r]) {
            enum say say = SAY_PART;
            RMAP_TRY(receive(self, r, false, &say, err));
            self->ended[r] = say == SAY_END;
        }
    for (int r = 1; r < size; r++)
        RMAP_TRY(RMAP_MPI(MPI_Wait(&self->request[r], MPI_STATUS_IGNORE)));
out:
    return st;
}

static enum rmap_status collect(struct stream *self, enum rmap_status begun, struct rmap_error *err)
{
    struct rmap_error late = {0};
    enum rmap_status st = begun == RMAP_OK ? gather(self, err) : begun;
    enum rmap_status ended = conclude(self, st == RMAP_OK ? err : &late);
    return st == RMAP_OK ? ended : st;
}

static void stream_fini(struct stream *self)
{
    rmap_ray_parts_stop(self->parts);
    rmap_ray_order_fini(&self->order);
    rmap_free(self->next);
    rmap_free(self->ended);
    rmap_free(self->request);
    rmap_free(self->scratch);
    rmap_deal_fini(&self->deal);
}

enum rmap_status rmap_ray_stream(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_pick *pick, enum rmap_deal_kind deal,
                                 uint64_t limit, const struct rmap_ray_sink *sink, uint64_t *n_ret,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t size = (size_t)context->size;
    struct stream self = {.context = context,
                          .map = map,
                          .limit = limit,
                          .order = {.map = map, .sink = sink, .limit = limit}};
    self.next = rmap_alloc(size, sizeof *self.next);
    self.ended = rmap_alloc(size, sizeof *self.ended);
    self.request = rmap_alloc(size, sizeof *self.request);
    self.scratch = rmap_alloc(context->rank == 0 && size > 1 ? PIECE_NBYTES : 0, 1);
    if (!self.next || !self.ended || !self.request || !self.scratch)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d ranks", context->size);
    else
        st = rmap_deal_init(map, deal, context->size, &self.deal, err);
    RMAP_TRY(rmap_agree(context, st, err));
    st = rmap_ray_parts_start(map, pick, &self.deal, limit, context->rank, context->n_thread,
                              &self.parts, err);
    st = context->rank == 0 ? collect(&self, st, err) : serve(&self, st, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    *n_ret = self.order.n;
out:
    stream_fini(&self);
    return st;
}
