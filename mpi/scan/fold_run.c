/* SPDX-License-Identifier: MIT
 *
 * A fold over a whole map, its portions scattered over ranks and threads.
 */
#include "mpi/scan/fold_run.h"

#include "base/alloc.h"
#include "io/map/map_memory.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/deal.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/scan/scan.h"

/* What one thread adds to. */
struct worker {
    struct rmap_fold_scanner *scanner; /* made when first needed */
    void *state;
};

struct run {
    const struct rmap_fold *fold;
    struct rmap_deal deal;
    int rank;
    struct worker *worker;   /* [n_thread] */
    int n_thread;            /* as many as fit into a query's memory */
    _Atomic uint64_t n_done; /* portions, this rank's */
    struct rmap_progress progress;
    bool quiet; /* no thread is needed to show it */
};

static enum rmap_status add_parts(void *context, int thread, size_t first, size_t last,
                                  struct rmap_error *err)
{
    struct run *run = context;
    struct worker *worker = &run->worker[thread];
    enum rmap_status st = RMAP_OK;
    if (!worker->scanner)
        RMAP_TRY(rmap_fold_scanner_create(run->fold, &worker->scanner, err));
    for (size_t k = first; k < last; k++) {
        size_t n = 0;
        const size_t *portion = rmap_deal_part(&run->deal, run->rank, k, &n);
        for (size_t i = 0; i < n; i++)
            RMAP_TRY(rmap_fold_scanner_add(worker->scanner, worker->state, portion[i],
                                           portion[i] + 1, err));
        atomic_fetch_add(&run->n_done, n);
    }
out:
    return st;
}

static enum rmap_status show_progress(void *context, struct rmap_error *err)
{
    struct run *run = context;
    (void)err;
    rmap_progress_show(&run->progress, atomic_load(&run->n_done));
    return RMAP_OK;
}

/* Small maps are cut finer, so that every thread has some parts to take. */
static void choose_step(struct run *run, int n_rank)
{
    size_t few = rmap_map_n_portion(run->fold->map) / (4 * (size_t)n_rank * (size_t)run->n_thread);
    if (few < run->deal.step)
        run->deal.step = few > 0 ? few : 1;
}

/* The rank's share, in the state of its first thread. */
static enum rmap_status add_share(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = run->fold;
    struct rmap_parts parts = {.last = rmap_deal_n_part(&run->deal, run->rank),
                               .step = 1,
                               .order = RMAP_PARTS_NEAR, /* parts share chunks */
                               .context = run,
                               .work = add_parts,
                               .meanwhile = run->quiet ? NULL : show_progress};
    for (int i = 0; i < run->n_thread; i++)
        RMAP_TRY(fold->kind->create(fold->context, &run->worker[i].state, err));
    RMAP_TRY(rmap_parts_run(&parts, run->n_thread, err));
    for (int i = 1; i < run->n_thread; i++)
        RMAP_TRY(fold->kind->merge(run->worker[0].state, run->worker[i].state, err));
out:
    return st;
}

/* MPI counts in int. */
enum { PIECE_NBYTES = 1 << 30 };

/* A rank's part in one round of handing states on. */
struct round {
    int sender, receiver; /* -1: none */
    uint8_t *bytes;
    size_t nbytes;
};

static enum rmap_status pass_bytes(const struct rmap_context *context, struct round *round,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < round->nbytes && st == RMAP_OK; at += PIECE_NBYTES) {
        size_t left = round->nbytes - at;
        int n = (int)(left < PIECE_NBYTES ? left : PIECE_NBYTES);
        if (round->receiver >= 0)
            st = RMAP_MPI(
                MPI_Send(round->bytes + at, n, MPI_BYTE, round->receiver, 0, context->comm));
        else
            st = RMAP_MPI(MPI_Recv(round->bytes + at, n, MPI_BYTE, round->sender, 0, context->comm,
                                   MPI_STATUS_IGNORE));
    }
    return st;
}

/* The bytes to send, or room for those that come: nothing travels before all ranks have it. */
static enum rmap_status prepare(const struct rmap_context *context, const struct rmap_fold *fold,
                                const void *state, struct round *round, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t nbytes = 0;
    if (round->receiver >= 0) {
        st = rmap_fold_pack(fold, state, &round->bytes, &round->nbytes, err);
        nbytes = st == RMAP_OK ? round->nbytes : 0;
        enum rmap_status sent =
            RMAP_MPI(MPI_Send(&nbytes, 1, MPI_UINT64_T, round->receiver, 0, context->comm));
        st = st == RMAP_OK ? sent : st;
    } else if (round->sender >= 0) {
        RMAP_TRY(RMAP_MPI(MPI_Recv(&nbytes, 1, MPI_UINT64_T, round->sender, 0, context->comm,
                                   MPI_STATUS_IGNORE)));
        round->nbytes = (size_t)nbytes;
        round->bytes = rmap_alloc(round->nbytes + 1, 1);
        if (!round->bytes)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for another rank's sums");
    }
out:
    return st;
}

static enum rmap_status take_over(const struct rmap_fold *fold, void *state,
                                  const struct round *round, struct rmap_error *err)
{
    void *other = NULL;
    enum rmap_status st = rmap_fold_unpack(fold, round->bytes, round->nbytes, &other, err);
    if (st == RMAP_OK)
        st = fold->kind->merge(state, other, err);
    fold->kind->destroy(other);
    return st;
}

/* Collective. Pairs, pairs of pairs and so on: rank 0 ends with the sum of all. */
static enum rmap_status gather(const struct rmap_context *context, const struct rmap_fold *fold,
                               void *state, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int step = 1; step < context->size && st == RMAP_OK; step *= 2) {
        int place = context->rank % (2 * step);
        struct round round = {-1, -1, NULL, 0};
        if (place == step)
            round.receiver = context->rank - step;
        if (place == 0 && context->rank + step < context->size)
            round.sender = context->rank + step;
        st = prepare(context, fold, state, &round, err);
        st = rmap_agree(context, st, err);
        if (st == RMAP_OK)
            st = pass_bytes(context, &round, err);
        if (st == RMAP_OK && round.sender >= 0)
            st = take_over(fold, state, &round, err);
        st = rmap_agree(context, st, err);
        rmap_free(round.bytes);
    }
    return st;
}

/* Collective. */
static enum rmap_status tell_nbytes(const struct rmap_context *context, const struct run *run,
                                    struct rmap_error *err)
{
    uint64_t nbytes = 0;
    for (int i = 0; i < run->n_thread; i++)
        nbytes += run->worker[i].scanner ? rmap_fold_scanner_nbytes(run->worker[i].scanner) : 0;
    return RMAP_MPI(
        MPI_Reduce(&nbytes, run->fold->nbytes_ret, 1, MPI_UINT64_T, MPI_SUM, 0, context->comm));
}

enum rmap_status rmap_fold_run(const struct rmap_context *context, const struct rmap_fold *fold,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct run run = {.fold = fold, .rank = context->rank, .quiet = context->quiet};
    *state_ret = NULL;
    run.n_thread = rmap_map_readers(fold->map, fold->columns, 2, context->n_thread);
    run.worker = rmap_alloc((size_t)run.n_thread, sizeof *run.worker);
    if (run.worker)
        st = rmap_deal_init(fold->map, RMAP_DEAL_SHARES, context->size, &run.deal, err);
    else
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", run.n_thread);
    if (st == RMAP_OK) {
        choose_step(&run, context->size);
        const size_t n_own = run.deal.first[run.rank + 1] - run.deal.first[run.rank];
        rmap_progress_init(&run.progress, context, "portions", n_own);
        st = add_share(&run, err);
        rmap_progress_fini(&run.progress);
    }
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(gather(context, fold, run.worker[0].state, err));
    if (fold->nbytes_ret)
        RMAP_TRY(tell_nbytes(context, &run, err));
    if (context->rank == 0) {
        *state_ret = run.worker[0].state;
        run.worker[0].state = NULL;
    }
out:
    for (int i = 0; run.worker && i < run.n_thread; i++) {
        rmap_fold_scanner_destroy(run.worker[i].scanner);
        fold->kind->destroy(run.worker[i].state);
    }
    rmap_free(run.worker);
    rmap_deal_fini(&run.deal);
    return st;
}
